#include "catch.h"
#include "checkpoint.h"
#include "samples.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/texturing/texel_faces.h>

#include <fstream>
#include <span>

using namespace studio;

namespace
{

/// How far a color is from the nearest of the picture's.
float off_palette(const Raster8& picture, Vec3f rgb)
{
    float nearest = 9;
    for (std::size_t i = 0; i < picture.values.size(); i += 3)
    {
        const Vec3f own{static_cast<float>(picture.values[i]), static_cast<float>(picture.values[i + 1]),
                        static_cast<float>(picture.values[i + 2])};
        nearest = std::min(nearest, length(own * (1 / 255.0F) - rgb));
    }
    return nearest;
}

template <class Work>
void for_each_painted(const Texture& texture, const Work& work)
{
    for (int y = 0; y < texture.size_px(); ++y)
        for (int x = 0; x < texture.size_px(); ++x)
            if (texture.seen.at(x, y) != 0)
                work(x, y);
}

/// Mean luminance of a part of the wall, from `from` to `to` meters along it.
double mean_light(const Texture& texture, double from, double to)
{
    double sum = 0;
    double count = 0;
    for_each_painted(texture,
                     [&](int x, int y)
                     {
                         const double at = on_wall(texture.size_px(), x, y).x;
                         if (at < from || at > to)
                             return;
                         sum += static_cast<double>(luminance(color_at(texture, x, y)));
                         ++count;
                     });
    return sum / count;
}

/// Mean color of a block of texels.
Vec3f mean_color(const Texture& texture, int left, int top, int side)
{
    Vec3f sum;
    for (int y = top; y < top + side; ++y)
        for (int x = left; x < left + side; ++x)
            sum += color_at(texture, x, y);
    return sum * (1 / static_cast<float>(side * side));
}

double correlation(const std::vector<std::pair<double, double>>& pairs)
{
    const auto n = static_cast<double>(pairs.size());
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (const auto& [x, y] : pairs)
    {
        a += x / n;
        b += y / n;
    }
    for (const auto& [x, y] : pairs)
    {
        aa += (x - a) * (x - a);
        bb += (y - b) * (y - b);
        ab += (x - a) * (y - b);
    }
    return ab / std::sqrt(aa * bb);
}

/// How the light of a painted wall goes with that of a texture `times` as large.
double alike(const Texture& small, const Texture& large, int times)
{
    std::vector<std::pair<double, double>> light;
    for_each_painted(small,
                     [&](int x, int y)
                     {
                         if (on_wall(small.size_px(), x, y).x >= 0)
                             light.emplace_back(luminance(color_at(small, x, y)),
                                                luminance(mean_color(large, times * x, times * y, times)));
                     });
    REQUIRE(light.size() > 2500);
    return correlation(light);
}

double turn_between(double a, double b)
{
    return std::abs(std::remainder(a - b, 2 * std::numbers::pi));
}

}  // namespace

TEST_CASE("every texel that a chart touches is painted in the picture's colors and marked as seen")
{
    Studio wall;
    testing::TestRun run;
    const Painted painted = wall.paint(run, Studio::options({{"patch_px", 11}}));
    REQUIRE(painted.texture->size_px() == 128);
    CHECK(painted.texture->atlas == atlas_id(wall.mesh));
    CHECK(painted.source->atlas == atlas_id(wall.mesh));
    CHECK(painted.texture->values == "display");
    CHECK(painted.source->picture_width == 96);
    CHECK(painted.source->picture_height == 80);
    const auto faces = texturing::find_texel_faces(wall.mesh, texturing::find_charts(wall.mesh), 128, run);
    std::size_t wrong = 0;
    float farthest = 0;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x)
        {
            const bool covered = faces.covered(static_cast<std::size_t>(y * 128 + x));
            wrong += painted.texture->seen.at(x, y) != (covered ? 1 : 0);
            wrong += painted.source->place(x, y).has_value() != covered;
            if (covered)
                farthest = std::max(farthest, off_palette(wall.picture, color_at(*painted.texture, x, y)));
        }
    CHECK(wrong == 0);
    CHECK(farthest < 0.15F);
    CHECK(run.reported.at("unseen_share").as_double() == 0);
    CHECK(run.reported.at("up").as_list().size() == 3);
    for (const char* key : {"stroke_px", "picture_width_cm", "picture_height_cm", "texel_mm", "searched_texel_mm",
                            "searched_texels", "patches", "keys"})
        CHECK(run.reported.at(key).as_double() > 0);
}

TEST_CASE("the painting keeps what the start shows, more so the more faithful it is")
{
    Studio wall;
    wall.start = start_of(wall.mesh, 96,
                          [](Vec2f uv) {
                              return uv.x < 0.5F ? Vec3f{0.9F, 0.8F, 0.5F} : Vec3f{0.1F, 0.1F, 0.3F};
                          });
    double gap = 2;
    for (const double painterly : {0.0, 0.5, 1.0})
    {
        CAPTURE(painterly);
        const Painted painted = wall.paint({{"painterly", painterly}});
        const double own = mean_light(*painted.texture, 0.05, 0.9) - mean_light(*painted.texture, 1.1, 1.95);
        CHECK(own > 0.12);
        CHECK(own < gap + 0.05);
        gap = own;
    }
}

TEST_CASE("what the start does not know is painted too, and its share reported")
{
    Studio wall;
    const Texture whole = wall.start;
    for (int y = 0; y < 96; ++y)
        for (int x = 48; x < 96; ++x)
        {
            wall.start.seen.at(x, y) = 0;
            for (int c = 0; c < 3; ++c)
                wall.start.layers[0].at(x, y, c) = 0;
        }
    testing::TestRun run;
    const Painted painted = wall.paint(run, Studio::options());
    CHECK(run.reported.at("unseen_share").as_double() == Approx(0.5).margin(0.02));
    CHECK(painted.texture->seen == wall.paint().texture->seen);
    float farthest = 0;
    for_each_painted(*painted.texture, [&](int x, int y)
                     { farthest = std::max(farthest, off_palette(wall.picture, color_at(*painted.texture, x, y))); });
    CHECK(farthest < 0.15F);
    // It continues the known half: the seam does not show.
    CHECK(std::abs(mean_light(*painted.texture, 0.8, 1) - mean_light(*painted.texture, 1, 1.2)) < 0.12);
    wall.start.seen = Raster8(96, 96);
    CHECK_THROWS_WITH(wall.paint(), Catch::Contains("has no texel"));
}

TEST_CASE("a larger texture shows the same motifs in the same places")
{
    Studio wall;
    const Painted small = wall.paint({{"size_px", 128}});
    for (const int times : {2, 4})
    {
        CAPTURE(times);
        const Painted large = wall.paint({{"size_px", 128 * times}});
        std::size_t same = 0;
        std::size_t count = 0;
        for_each_painted(*small.texture,
                         [&](int x, int y)
                         {
                             ++count;
                             same += length(small.source->place(x, y)->at - large.source->place(times * x, times * y)->at) < 2;
                         });
        CHECK(alike(*small.texture, *large.texture, times) > 0.9);
        CHECK(same > count / 2);
        CHECK(large.source->pixels_per_texel == Approx(small.source->pixels_per_texel / static_cast<float>(times)));
    }
}

TEST_CASE("a preview of one level fewer shows the motifs of the start where the finished painting does")
{
    Studio wall;
    wall.picture = brush_picture(160, 128, 21);
    wall.start = start_of(wall.mesh, 96,
                          [](Vec2f uv)
                          {
                              const float wave = std::sin(60 * uv.x) * std::cos(50 * uv.y);
                              return Vec3f{0.5F + 0.3F * wave, 0.5F + 0.3F * wave, 0.5F + 0.1F * wave};
                          });
    // Texels of 2.6 and 1.3 cm: strokes of 12 cm are painted at levels of 3 and 1.5 cm.
    const auto painted = [&](int size, int seed) {
        return wall.paint({{"size_px", size}, {"stroke_cm", 12.0}, {"painterly", 1.0}, {"seed", seed}});
    };
    const Painted small = painted(128, 0);
    const double same_seed = alike(*small.texture, *painted(256, 0).texture, 2);
    CHECK(same_seed > 0.55);
    CHECK(same_seed > alike(*small.texture, *painted(256, 5).texture, 2) + 0.1);
}

TEST_CASE("the start is given the picture's colors unless it has them")
{
    Studio wall;
    wall.start = start_of(wall.mesh, 96, [](Vec2f uv) { return Vec3f{0.08F + 0.1F * uv.x, 0.12F, 0.3F}; });
    Vec3f mean;
    for (std::size_t i = 0; i < wall.picture.values.size(); i += 3)
        mean += Vec3f{static_cast<float>(wall.picture.values[i]), static_cast<float>(wall.picture.values[i + 1]),
                      static_cast<float>(wall.picture.values[i + 2])} *
                (3.0F / 255 / static_cast<float>(wall.picture.values.size()));
    const double usual = static_cast<double>(luminance(mean));
    const double recolored = mean_light(*wall.paint({{"painterly", 0.0}}).texture, 0, 2);
    const double kept = mean_light(*wall.paint({{"painterly", 0.0}, {"recolor", false}}).texture, 0, 2);
    CHECK(recolored == Approx(usual).margin(0.06));
    CHECK(kept < usual - 0.12);
}

TEST_CASE("the source map leads to what was painted, and its angles turn with the charts")
{
    Studio wall;
    const Painted painted = wall.paint({{"size_px", 256}});
    const SourceMap& source = *painted.source;
    std::vector<std::pair<double, double>> light;
    double difference = 0;
    double unshifted = 0;
    std::size_t turned = 0;
    std::size_t pairs = 0;
    std::size_t followed = 0;
    for_each_painted(*painted.texture,
                     [&](int x, int y)
                     {
                         const SourceMap::Place place = *source.place(x, y);
                         const auto pixel = [](float at, int size) { return std::clamp(static_cast<int>(at), 0, size - 1); };
                         const std::uint8_t* rgb = &wall.picture.at(pixel(place.at.x, 96), pixel(place.at.y, 80));
                         const Vec3f copied =
                             Vec3f{static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])} *
                             (1 / 255.0F);
                         const Vec3f own = color_at(*painted.texture, x, y);
                         light.emplace_back(luminance(copied + place.shift), luminance(own));
                         difference += static_cast<double>(length(copied + place.shift - own));
                         unshifted += static_cast<double>(length(copied - own));
                         turned += turn_between(static_cast<double>(place.angle), x < 128 ? 0 : std::numbers::pi) > 0.01;
                         if (on_wall(256, x, y).x < 0 || on_wall(256, x + 1, y).x < 0)
                             return;
                         // One texel to the right.
                         const Vec2f step = source.place(x + 1, y)->at - place.at;
                         const Vec2f told = Vec2f{std::cos(place.angle), std::sin(place.angle)} * source.pixels_per_texel;
                         ++pairs;
                         followed += length(step - told) < 0.05F;
                     });
    CHECK(turned == 0);
    CHECK(correlation(light) > 0.9);
    CHECK(difference / static_cast<double>(light.size()) < 0.08);
    CHECK(difference < 0.8 * unshifted);
    CHECK(followed > pairs * 3 / 5);
}

TEST_CASE("transparent parts of the picture are not copied, and alpha that hides nothing changes nothing")
{
    Studio wall;
    const Painted plain = wall.paint({{"up", "y"}});
    const Raster8 rgb = wall.picture;
    const auto with_alpha = [&](std::uint8_t alpha_at_right)
    {
        wall.picture = Raster8(96, 80, 4, 255);
        for (int y = 0; y < 80; ++y)
            for (int x = 0; x < 96; ++x)
            {
                std::copy_n(&rgb.at(x, y), 3, &wall.picture.at(x, y));
                if (x >= 60)
                    wall.picture.at(x, y, 3) = alpha_at_right;
            }
    };
    with_alpha(250);
    CHECK(wall.paint({{"up", "y"}}).bytes == plain.bytes);
    for (const char* direction : {"none", "gravity"})
    {
        with_alpha(249);
        const Painted part = wall.paint({{"direction", direction}, {"up", "y"}});
        float rightmost = 0;
        for_each_painted(*part.texture, [&](int x, int y) { rightmost = std::max(rightmost, part.source->place(x, y)->at.x); });
        CHECK(rightmost > 40);
        CHECK(rightmost < 60);
        // The colors stored below transparent pixels have no influence.
        for (int y = 0; y < 80; ++y)
            std::fill_n(&wall.picture.at(60, y), 4 * 36, std::uint8_t{0});
        CHECK(wall.paint({{"direction", direction}, {"up", "y"}}).bytes == part.bytes);
    }
    wall.picture = Raster8(96, 80, 4, 0);
    CHECK_THROWS_WITH(wall.paint({{"up", "y"}}), Catch::Contains("port 'style'") && Catch::Contains("transparent everywhere"));
}

TEST_CASE("up comes from the option, or else from the cameras, or else from the mesh")
{
    struct Case
    {
        Value::Map options;
        std::optional<Vec3d> cameras;  ///< Their upward direction.
        Vec3d up;
    };
    const Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    const Value::Map automatic{{"up", "auto"}};
    for (const Case& c : {Case{{}, std::nullopt, z}, Case{automatic, std::nullopt, z}, Case{automatic, y, y},
                          Case{automatic, x * -1.0, x * -1.0}, Case{{{"up", "y"}}, x, y}})
    {
        Studio wall;
        if (c.cameras)
        {
            wall.frames = std::make_shared<Frames>();
            fresco::Frame frame;
            const Vec3d down = *c.cameras * -1.0;
            const Vec3d forward = std::abs(down.z) < 0.5 ? z * -1.0 : x;
            const Vec3d right = cross(down, forward);
            frame.color.world_from_camera.rotation.m = {right.x,   down.x,  forward.x, right.y,  down.y,
                                                        forward.y, right.z, down.z,    forward.z};
            wall.frames->frames.assign(3, frame);
        }
        testing::TestRun run;
        Value options = Studio::options({{"rounds_count", 1}, {"levels_count", 1}, {"stroke_cm", 40.0}});
        for (const auto& [name, value] : c.options)
            options.set(name, value);
        const Painted painted = wall.paint(run, options);
        const auto& told = run.reported.at("up").as_list();
        CHECK(length(Vec3d{told[0].as_double(), told[1].as_double(), told[2].as_double()} - c.up) < 1e-5);
        // In the left chart v runs along y.
        const double expected = c.up.y > 0.5 ? 0 : c.up.x < -0.5 ? std::numbers::pi / 2 : -1;
        if (expected != -1)
            CHECK(turn_between(static_cast<double>(painted.source->place(30, 90)->angle), expected) < 0.01);
    }
}

TEST_CASE("previews are pictures of the painting so far")
{
    Studio wall;
    testing::TestRun run;
    const Painted painted = wall.paint(run, Studio::options({{"preview_seconds", 0.0}}));
    const auto file = run.preview_folder() / "texture.png";
    REQUIRE(std::filesystem::exists(file));
    const Raster8 preview = stored_png::Codec().read_rgb(file);
    REQUIRE(preview.width == 128);
    double difference = 0;
    for (std::size_t i = 0; i < preview.values.size(); ++i)
        difference = std::max(difference, std::abs(static_cast<double>(preview.values[i]) -
                                                   255 * static_cast<double>(painted.texture->layers[0].values[i])));
    CHECK(difference <= 0.51);
    CHECK((painted.bytes == wall.paint().bytes));
}

TEST_CASE("the stage names what it cannot use")
{
    struct Case
    {
        std::function<void(Studio&, Value&)> change;
        const char* place;
        const char* word;
    };
    const auto changed_mesh = [](const std::function<void(Mesh&)>& change)
    {
        return [change](Studio& s, Value&)
        {
            change(s.mesh);
            s.start.atlas.clear();
        };
    };
    const auto all_positions = [](Mesh& mesh)
    {
        for (Vec3f& position : mesh.positions)
            position = position * 100000.0F;
    };
    const auto small_picture = [](Studio& s, Value& o)
    {
        s.picture = brush_picture(5, 60, 1);
        o.set("patch_px", 11);
    };
    const Case cases[] = {{[](Studio& s, Value&) { s.mesh.texcoords.clear(); }, "port 'mesh'", "no texcoords"},
                          {changed_mesh(
                               [](Mesh& mesh) {
                                   mesh.texcoords.assign(12, {0.5F, 0.5F});
                               }),
                           "mesh", "area"},
                          {changed_mesh([](Mesh& mesh) { mesh.triangles[0][0] = 99; }), "port 'mesh'", "99"},
                          {changed_mesh(all_positions), "strokes of 16 cm", "unit_m"},
                          {[](Studio& s, Value&) { s.start.atlas = std::string(32, 'a'); }, "port 'start'", "atlas"},
                          {[](Studio& s, Value&) { s.start.seen = Raster8(96, 96); }, "port 'start'", "has no texel"},
                          {[](Studio& s, Value&) { s.start.layers[0].values[5] = NAN; }, "texel (1, 0)", "finite"},
                          {small_picture, "style picture", "5x60"},
                          {[](Studio& s, Value&) { s.picture = Raster8(96, 96, 3, 120); }, "style picture", "a single color"},
                          {[](Studio& s, Value&) { s.picture = Raster8(96, 96, 1, 120); }, "style picture", "RGB"},
                          {[](Studio&, Value& o) { o.set("stroke_cm", 0.5); }, "stroke_cm", "5.21 or more"},
                          {[](Studio&, Value& o) { o.set("stroke_cm", 201); }, "stroke_cm", "200 cm long"}};
    for (const Case& c : cases)
    {
        CAPTURE(c.place, c.word);
        Studio wall;
        Value options = Studio::options();
        c.change(wall, options);
        testing::TestRun run;
        CHECK_THROWS_WITH(wall.paint(run, options), Catch::Contains(c.place) && Catch::Contains(c.word));
    }
}

namespace
{

/// Checkpoints after every round; as little work as there can be.
Value small_options(double checkpoint_seconds = 1e-9)
{
    return Studio::options(
        {{"stroke_cm", 30.0}, {"patch_px", 5}, {"size_px", 64}, {"detail", 1.0}, {"checkpoint_seconds", checkpoint_seconds}});
}

Studio small_wall()
{
    Studio wall;
    wall.picture = brush_picture(60, 50, 3);
    // Stripes of 15 cm: two rounds with strokes of half the width.
    wall.start = start_of(wall.mesh, 96,
                          [](Vec2f uv)
                          {
                              const float light = 0.5F + 0.25F * std::sin(uv.x * 140);
                              return Vec3f{light, light, light};
                          });
    return wall;
}

bool has_line(const testing::TestRun& run, std::string_view text)
{
    return std::ranges::any_of(run.messages, [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

}  // namespace

TEST_CASE("a run that is canceled anywhere goes on to the same bytes")
{
    const Studio wall = small_wall();
    testing::TestRun whole(1);
    const auto expected = wall.paint(whole, small_options()).bytes;
    REQUIRE(whole.metrics.at("distance").size() == 8);
    int gone_on = 0;
    int checks = 1;
    for (bool canceled = true; canceled; checks += 1 + checks / 6)
    {
        CAPTURE(checks);
        testing::TestRun run(checks % 2 + 1);
        run.cancel_after(checks);
        canceled = false;
        try
        {
            wall.paint(run, small_options());
        }
        catch (const Canceled&)
        {
            canceled = true;
        }
        const std::size_t rounds = run.metrics["distance"].size();
        run.cancel_after(1 << 30);
        if (!canceled)
            break;
        CHECK((wall.paint(run, small_options()).bytes == expected));
        CHECK(run.metrics["distance"].size() == 8);
        CHECK(has_line(run, "going on after round") == (rounds > 0));
        gone_on += rounds > 0;
    }
    CHECK(gone_on >= 5);
    CHECK(checks > 50);
}

TEST_CASE("checkpoints are written as often as asked for")
{
    const Studio wall = small_wall();
    for (const auto& [seconds, is_kept] : {std::pair{0.0, false}, std::pair{1e-9, true}, std::pair{3600.0, false}})
    {
        CAPTURE(seconds);
        testing::TestRun run;
        wall.paint(run, small_options(seconds));
        CHECK(std::filesystem::is_empty(run.checkpoint_folder()) != is_kept);
    }
}

TEST_CASE("a checkpoint that cannot be used is named in a warning, and the run begins again")
{
    const Studio wall = small_wall();
    testing::TestRun whole;
    const auto expected = wall.paint(whole, small_options()).bytes;
    const auto file = whole.checkpoint_folder() / "round.bin";
    const auto good = synthesize::read_checkpoint(file);
    REQUIRE(good);
    const auto bytes = read_file(file);

    testing::TestRun cut;
    write_file(cut.checkpoint_folder() / "round.bin", std::span(bytes).first(bytes.size() / 2));
    CHECK((wall.paint(cut, small_options()).bytes == expected));
    CHECK(has_line(cut, "warning: the checkpoint cannot be used"));
    CHECK(has_line(cut, "round.bin"));

    // Whole, but of other work.
    struct Case
    {
        const char* name;
        std::function<void(synthesize::Checkpoint&)> change;
    };
    const Case cases[] = {{"more patches", [](auto& c) { c.matches.emplace_back(); }},
                          {"of a level that there is not", [](auto& c) { c.level = 7; }},
                          {"too many rounds", [](auto& c) { c.rounds = 9; }},
                          {"a distance that is no number", [](auto& c) { c.matches[3].distance = NAN; }},
                          {"a shift that is no number", [](auto& c) { c.matches[3].shift.y = NAN; }},
                          {"a shift beyond the limit", [](auto& c) {
                               c.matches[3].shift = {20, 0, 0};
                           }}};
    for (const Case& c : cases)
    {
        CAPTURE(c.name);
        synthesize::Checkpoint other = *good;
        c.change(other);
        testing::TestRun run;
        synthesize::write_checkpoint(run.checkpoint_folder() / "round.bin", other);
        CHECK((wall.paint(run, small_options()).bytes == expected));
        CHECK(has_line(run, "warning: the checkpoint cannot be used"));
    }
}

namespace
{

Checkpoint sample(std::size_t matches)
{
    Checkpoint result{2, 5, {}, {1, 2.5F}};
    for (std::size_t i = 0; i < matches; ++i)
        result.matches.push_back({{3, static_cast<float>(i)}, 7.25F});
    return result;
}

/// Whether damaged bytes are refused by an error that names the file.
bool is_refused(const std::filesystem::path& file, std::span<const std::byte> bytes)
{
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    try
    {
        return !read_checkpoint(file);
    }
    catch (const Error& error)
    {
        return std::string(error.what()).find(file.string()) != std::string::npos;
    }
}

}  // namespace

TEST_CASE("a damaged checkpoint is refused by name")
{
    testing::TemporaryFolder folder;
    const auto file = folder.path() / "round.bin";
    write_checkpoint(file, sample(2));
    std::vector<std::byte> bytes = read_file(file);
    std::size_t read = 0;
    for (std::size_t length = 0; length < bytes.size(); ++length)
        read += !is_refused(file, std::span(bytes).first(length));
    CHECK(read == 0);
    for (std::size_t i = 0; i < bytes.size(); ++i)
    {
        const std::byte whole = bytes[i];
        bytes[i] ^= static_cast<std::byte>(1U << i % 8);
        read += !is_refused(file, bytes);
        bytes[i] = whole;
    }
    CHECK(read == 0);
    bytes.push_back(std::byte{0});
    CHECK(is_refused(file, bytes));
    bytes.pop_back();
    CHECK_FALSE(is_refused(file, bytes));
    std::filesystem::remove(file);
    std::filesystem::create_directory(file);
    CHECK_THROWS_WITH(read_checkpoint(file), Catch::Contains("round.bin"));
}

#include "catch.h"
#include "samples.h"

#include <fresco/error.h>
#include <fresco/testing.h>

using namespace studio;

namespace
{

Vec3f color_of(const std::uint8_t* rgb)
{
    return Vec3f{static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])} * (1 / 255.0F);
}

/// How far a color is from the nearest of the picture's.
float off_palette(const Raster8& picture, Vec3f rgb)
{
    float nearest = 9;
    for (std::size_t i = 0; i < picture.values.size(); i += 3)
        nearest = std::min(nearest, length(color_of(&picture.values[i]) - rgb));
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
double mean_light(const Painted& painted, double from, double to)
{
    const Texture& texture = *painted.texture;
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

/// How far the light of a painted wall is from that of a texture twice as large.
double light_apart(const Painted& small, const Painted& large)
{
    double sum = 0;
    for_each_painted(*small.texture,
                     [&](int x, int y)
                     {
                         const auto at = [&](int i, int j) { return color_at(*large.texture, 2 * x + i, 2 * y + j); };
                         const Vec3f mean = (at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1)) * 0.25F;
                         sum += static_cast<double>(std::abs(luminance(color_at(*small.texture, x, y) - mean)));
                     });
    return sum;
}

double turn_between(double a, double b)
{
    return std::abs(std::remainder(a - b, 2 * std::numbers::pi));
}

struct WithWall
{
    Studio wall;
};

}  // namespace

TEST_CASE_METHOD(WithWall, "the painting keeps what the start shows, more so the more faithful it is")
{
    wall.start = start_of(wall.mesh, 96,
                          [](Vec2f uv) {
                              return uv.x < 0.5F ? Vec3f{0.9F, 0.8F, 0.5F} : Vec3f{0.1F, 0.1F, 0.3F};
                          });
    double gap = 2;
    for (const double painterly : {0.0, 0.5, 1.0})
    {
        CAPTURE(painterly);
        const Painted painted = wall.paint({{"painterly", painterly}});
        const double own = mean_light(painted, 0.05, 0.9) - mean_light(painted, 1.1, 1.95);
        CHECK(own > 0.12);
        CHECK(own < gap + 0.05);
        gap = own;
    }
}

TEST_CASE_METHOD(WithWall, "what the start does not know is painted too, and its share reported")
{
    for (int y = 0; y < 96; ++y)
        for (int x = 48; x < 96; ++x)
        {
            wall.start.seen.at(x, y) = 0;
            std::fill_n(&wall.start.layers[0].at(x, y), 3, 0.0F);
        }
    const Painted painted = wall.paint();
    CHECK((painted.texture->atlas == atlas_id(wall.mesh) && painted.source->atlas == atlas_id(wall.mesh)));
    CHECK(painted.reported.at("unseen_share").as_double() == Approx(0.5).margin(0.02));
    CHECK(std::ranges::count(painted.texture->seen.values, 1) > 2500);
    float farthest = 0;
    for_each_painted(*painted.texture, [&](int x, int y)
                     { farthest = std::max(farthest, off_palette(wall.picture, color_at(*painted.texture, x, y))); });
    CHECK(farthest < 0.15F);
    // It continues the known half: the seam does not show.
    CHECK(std::abs(mean_light(painted, 0.8, 1) - mean_light(painted, 1, 1.2)) < 0.12);
}

TEST_CASE_METHOD(WithWall, "a larger texture shows the same motifs in the same places, also one with a level more")
{
    const Painted small = wall.paint();
    const Painted large = wall.paint({{"size_px", 256}});
    std::size_t same = 0;
    std::size_t count = 0;
    for_each_painted(*small.texture,
                     [&](int x, int y)
                     {
                         ++count;
                         same += length(small.source->place(x, y)->at - large.source->place(2 * x, 2 * y)->at) < 2;
                     });
    CHECK(same > count / 2);
    CHECK(large.source->pixels_per_texel == Approx(small.source->pixels_per_texel / 2));

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
    const Painted coarse = painted(128, 0);
    CHECK(light_apart(coarse, painted(256, 0)) < 0.8 * light_apart(coarse, painted(256, 5)));
}

TEST_CASE_METHOD(WithWall, "the start is given the picture's colors unless it has them")
{
    wall.start = start_of(wall.mesh, 96, [](Vec2f uv) { return Vec3f{0.08F + 0.1F * uv.x, 0.12F, 0.3F}; });
    Vec3f mean;
    for (std::size_t i = 0; i < wall.picture.values.size(); i += 3)
        mean += color_of(&wall.picture.values[i]) * (3 / static_cast<float>(wall.picture.values.size()));
    const auto usual = static_cast<double>(luminance(mean));
    CHECK(mean_light(wall.paint({{"painterly", 0.0}}), 0, 2) == Approx(usual).margin(0.06));
    CHECK(mean_light(wall.paint({{"painterly", 0.0}, {"recolor", false}}), 0, 2) < usual - 0.12);
}

TEST_CASE_METHOD(WithWall, "transparent parts of the picture are not copied, and alpha that hides nothing changes nothing")
{
    const Painted plain = wall.paint({{"up", "y"}});
    const Raster8 rgb = wall.picture;
    const auto with_alpha = [&](int alpha_at_right)
    {
        wall.picture = testing::picture(
            96, 80, [&](int x, int y, int c) { return c < 3    ? rgb.at(x, y, c)
                                                      : x < 60 ? 255
                                                               : alpha_at_right; }, 4);
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
}

TEST_CASE("up comes from the option, or else from the cameras, or else from the mesh")
{
    struct Case
    {
        const char* option;
        std::optional<Vec3d> cameras;  ///< Their upward direction.
        Vec3d up;
        double angle;  ///< Angle of strokes in the left chart, where v runs along y.
    };
    const Vec3d y{0, 1, 0}, z{0, 0, 1};
    for (const Case& c : {Case{"auto", std::nullopt, z, 0}, Case{"auto", Vec3d{-1, 0, 0}, {-1, 0, 0}, std::numbers::pi / 2},
                          Case{"y", Vec3d{1, 0, 0}, y, 0}})
    {
        Studio wall;
        if (c.cameras)
        {
            fresco::Frame frame;
            frame.color.world_from_camera = testing::looking_at({}, z * -1.0, *c.cameras);
            wall.frames = std::make_shared<Frames>();
            wall.frames->frames.assign(3, frame);
        }
        const Painted painted = wall.paint({{"rounds_count", 1}, {"levels_count", 1}, {"stroke_cm", 40.0}, {"up", c.option}});
        const auto& told = painted.reported.at("up").as_list();
        CHECK(length(Vec3d{told[0].as_double(), told[1].as_double(), told[2].as_double()} - c.up) < 1e-5);
        // The right chart is turned by half a turn in the atlas.
        const auto angle_at = [&](int x) { return static_cast<double>(painted.source->place(x, 90)->angle); };
        if (c.up.z == 0)
            CHECK((turn_between(angle_at(30), c.angle) < 0.01 && turn_between(angle_at(96), c.angle) > 3.13));
    }
}

TEST_CASE("the stage names what it cannot use")
{
    struct Case
    {
        std::function<void(Studio&, Value::Map&)> change;
        const char* place;
        const char* word;
    };
    const auto changed_mesh = [](const std::function<void(Mesh&)>& change)
    {
        return [change](Studio& s, Value::Map&)
        {
            change(s.mesh);
            s.start.atlas.clear();
        };
    };
    const auto changed_picture = [](const Raster8& picture)
    { return [picture](Studio& s, Value::Map&) { s.picture = picture; }; };
    const auto options = [](const Value::Map& map) { return [map](Studio&, Value::Map& o) { o = map; }; };
    const auto all_positions = [](Mesh& mesh)
    {
        for (Vec3f& position : mesh.positions)
            position = position * 100000.0F;
    };
    const auto with_lines = [](const char* direction, const char* atlas)
    {
        return [=](Studio& s, Value::Map& o)
        {
            s.lines = std::make_shared<Texture>(s.start);
            s.lines->atlas = atlas;
            o = {{"direction", direction}};
        };
    };
    const Case cases[] = {{[](Studio& s, Value::Map&) { s.mesh.texcoords.clear(); }, "port 'mesh'", "no texcoords"},
                          {changed_mesh(
                               [](Mesh& mesh) {
                                   mesh.texcoords.assign(12, {0.5F, 0.5F});
                               }),
                           "mesh", "area"},
                          {changed_mesh([](Mesh& mesh) { mesh.triangles[0][0] = 99; }), "port 'mesh'", "99"},
                          {changed_mesh(all_positions), "strokes of 16 cm", "unit_m"},
                          {[](Studio& s, Value::Map&) { s.start.atlas = std::string(32, 'a'); }, "port 'start'", "atlas"},
                          {[](Studio& s, Value::Map&) { s.start.seen = Raster8(96, 96); }, "port 'start'", "has no texel"},
                          {[](Studio& s, Value::Map&) { s.start.layers[0].values[5] = NAN; }, "texel (1, 0)", "finite"},
                          {changed_picture(brush_picture(5, 60, 1)), "style picture", "5x60"},
                          {changed_picture(Raster8(96, 96, 1, 120)), "style picture", "RGB"},
                          {changed_picture(Raster8(96, 80, 4, 0)), "port 'style'", "transparent everywhere"},
                          {options({{"stroke_cm", 0.5}}), "stroke_cm", "5.21 or more"},
                          {options({{"stroke_cm", 201}}), "stroke_cm", "200 cm long"},
                          {options({{"direction", "drawn"}}), "drawn", "wire port 'lines'"},
                          {with_lines("gravity", ""), "port 'lines'", "set it to \"drawn\""},
                          {with_lines("drawn", "another"), "port 'lines'", "atlas"}};
    for (const Case& c : cases)
    {
        CAPTURE(c.place, c.word);
        Studio wall;
        Value::Map changed;
        c.change(wall, changed);
        CHECK_THROWS_WITH(wall.paint(changed), Catch::Contains(c.place) && Catch::Contains(c.word));
    }
}

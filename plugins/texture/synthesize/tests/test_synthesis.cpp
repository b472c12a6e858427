#include "catch.h"
#include "plain_synthesis.h"
#include "plugin_under_test.h"
#include "samples.h"
#include "stored_png.h"

#include "checkpoint.h"

#include <fresco/error.h>
#include <fresco/images/stroke_width.h>

using namespace samples;

namespace
{

float largest_difference(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b)
{
    float largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, length(a[i] - b[i]));
    return largest;
}

texturing::TexelFaces texel_faces(const WallTask& wall, int size_px)
{
    return texturing::find_texel_faces(wall.surface.mesh, wall.surface.charts, size_px, Progress());
}

/// Two places between which rounding may decide, be they a patch's own or continued from around.
bool is_tie(const plain::PlainLevel& twin, const plain::Searched& searched, std::size_t patch, Vec2f a, Vec2f b)
{
    for (const bool is_own_a : {false, true})
        for (const bool is_own_b : {false, true})
        {
            const double of_a = twin.score(patch, searched, a, is_own_a);
            const double of_b = twin.score(patch, searched, b, is_own_b);
            if (std::abs(of_a - of_b) <= 1e-3 * std::abs(of_a))
                return true;
        }
    return false;
}

/// Paints a round in both ways from the same state.
void compare_round(Level& level, const plain::PlainLevel& twin, Round round, testing::TestRun& run)
{
    const plain::Numbers crowding(level.crowding().begin(), level.crowding().end());
    const plain::Searched expected = twin.search(round, level.colors(), crowding, level.matches());
    level.paint_round(round, run);
    const std::vector<Match>& found = level.matches();
    REQUIRE(found.size() == expected.found.size());
    std::size_t elsewhere = 0;
    std::size_t wrong = 0;
    float worst = 0;
    float shift = 0;
    for (std::size_t p = 0; p < found.size(); ++p)
    {
        const Match& own = expected.found[p];
        if (length(found[p].at - own.at) > 2e-3F)
        {
            ++elsewhere;
            wrong += !is_tie(twin, expected, p, found[p].at, own.at);
            continue;
        }
        worst = std::max(worst, std::abs(found[p].distance - own.distance) / (1 + own.distance));
        shift = std::max(shift, length(found[p].shift - own.shift));
    }
    CHECK(wrong <= 1);  // A tie between places that a later pass left.
    CHECK(elsewhere <= found.size() / 50);
    CHECK(worst < 1e-3F);
    CHECK(shift < 1e-3F);
    CHECK(largest_difference(level.colors(), twin.voted(found)) < 0.01F);
    const plain::Numbers crowded = twin.crowded(crowding, found);
    for (std::size_t k = 0; k < crowded.size(); ++k)
        CHECK(level.crowding()[k] == Approx(crowded[k]).epsilon(1e-4));
}

void compare_texture(const Painting& painting, const std::map<std::size_t, plain::PlainLevel::Texel>& expected)
{
    const int size = painting.texture.size_px();
    float worst = 0;
    float farthest = 0;
    float shift = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const auto it = expected.find(static_cast<std::size_t>(y * size + x));
            const auto place = painting.source.place(x, y);
            REQUIRE(painting.texture.seen.at(x, y) == (it != expected.end() ? 1 : 0));
            REQUIRE(place.has_value() == (it != expected.end()));
            if (!place)
                continue;
            worst = std::max(worst, length(color_at(painting.texture, x, y) - it->second.rgb));
            shift = std::max(shift, length(place->shift - it->second.shift));
            const Vec2f told{std::clamp(it->second.place.x, 0.0F, static_cast<float>(painting.source.picture_width)),
                             std::clamp(it->second.place.y, 0.0F, static_cast<float>(painting.source.picture_height))};
            farthest = std::max(farthest, length(place->at - told));
        }
    CHECK(worst < 2e-3F);
    CHECK(farthest < 0.02F);
    CHECK(shift < 0.01F);
}

}  // namespace

TEST_CASE("a whole synthesis is that of a plain twin")
{
    WallTask wall(smooth_start);
    const LevelOptions usual{.side = 5,
                             .faithfulness = 0.27,
                             .unrest = 10,
                             .search = {.completeness = 2, .variety = 5, .lift = 8, .repeat_cost = 30, .weave_cost = 10}};
    const LevelOptions other{.side = 7,
                             .faithfulness = 0.45,
                             .unrest = 20,
                             .search = {.completeness = 0.5, .variety = 40, .repeat_cost = 80, .weave_cost = 60, .seed = 7}};
    for (const LevelOptions& options : {usual, other})
    {
        LevelOptions coarse_options = options;
        coarse_options.stride = 3;
        Level coarse(wall.task, 0.07, 0.45, coarse_options, wall.run);
        const plain::PlainLevel plain_coarse(wall.task, coarse, coarse_options);
        coarse.begin(nullptr, wall.run);
        CHECK(largest_difference(coarse.colors(), plain_coarse.begin_alone()) < 0.01F);
        for (int round = 0; round < 3; ++round)
            compare_round(coarse, plain_coarse, Round::searches, wall.run);

        Level fine(wall.task, 0.035, 0.9, options, wall.run);
        const plain::PlainLevel plain_fine(wall.task, fine, options);
        fine.begin(&coarse, wall.run);
        CHECK(largest_difference(fine.colors(), plain_fine.begin_after(plain_coarse, coarse.matches())) < 0.01F);
        const std::vector<Vec2f> places = plain_fine.places_after(plain_coarse, coarse.matches());
        REQUIRE(fine.matches().size() == places.size());
        for (std::size_t p = 0; p < places.size(); ++p)
            CHECK(length(fine.matches()[p].at - places[p]) < 0.01F);
        for (const Round round : {Round::searches, Round::refines, Round::searches})
            compare_round(fine, plain_fine, round, wall.run);
        for (const int size : {48, 180})
            compare_texture(paint(wall.task, fine, texel_faces(wall, size), wall.run), plain_fine.texture(size, fine.matches()));
    }
}

TEST_CASE("odd parts of a picture do not crowd where its color is missing")
{
    // Red wall; a blue picture with a checkered part that is as far from red.
    WallTask wall([](std::uint32_t, Vec2f) { return Vec3f{0.45F, 0.15F, 0.15F}; });
    wall.picture = Raster8(96, 96, 3);
    const auto is_odd = [](float x, float y) { return x >= 64 && y >= 64; };
    for (int y = 0; y < 96; ++y)
        for (int x = 0; x < 96; ++x)
        {
            const bool is_light = is_odd(static_cast<float>(x), static_cast<float>(y)) && (x / 3 + y / 3) % 2 == 0;
            const int grain = (x * 7 + y * 13) % 11;
            wall.picture.at(x, y) = static_cast<std::uint8_t>(is_light ? 200 : 30 + grain);
            (&wall.picture.at(x, y))[1] = static_cast<std::uint8_t>(is_light ? 180 : 40 + grain);
            (&wall.picture.at(x, y))[2] = static_cast<std::uint8_t>(is_light ? 60 : 110 + grain);
        }
    Level level(wall.task, 0.035, 1, {.side = 5, .search = {.lift = 5}}, wall.run);
    level.begin(nullptr, wall.run);
    level.paint_round(Round::searches, wall.run);
    const auto odd = std::ranges::count_if(level.matches(), [&](const Match& match) { return is_odd(match.at.x, match.at.y); });
    INFO(odd << " of " << level.matches().size());
    CHECK(static_cast<double>(odd) < 0.15 * static_cast<double>(level.matches().size()));
}

TEST_CASE("a synthesis is its levels, with strokes eight texels wide in the finest")
{
    WallTask wall(smooth_start);
    struct Case
    {
        double painterly, faithfulness;
        int levels, size, finest;  // Texels of the texture are 1 / 0.3 / size m wide.
    };
    const double half = 0.5 * std::pow(0.3, 0.5);
    for (const Case& c :
         {Case{0.5, half, 2, 128, 0}, Case{0, 0.5, 1, 128, 0}, Case{1, 0.15, 2, 50, 1}, Case{0.5, half, 3, 64, 0}})
    {
        CAPTURE(c.painterly, c.levels, c.size);
        testing::TestRun run;
        const SynthesisOptions options{.size_px = c.size,
                                       .stroke_m = 0.28,
                                       .painterly = c.painterly,
                                       .detail = 0,
                                       .patch_px = 5,
                                       .levels_count = c.levels,
                                       .rounds_count = 2,
                                       .seed = 3};
        const Painting whole = fresco::synthesize::synthesize(wall.task, options, nullptr, run);

        const double scale = 8 / stroke_width_px(wall.picture, run);
        std::unique_ptr<Level> level;
        for (int number = c.levels - 1; number >= c.finest; --number)
        {
            const LevelOptions o{.side = 5,
                                 .faithfulness = c.faithfulness,
                                 .unrest = 20 * c.painterly,
                                 .search = {.stroke_px = std::ldexp(8.0, -number),
                                            .variety = 10 * c.painterly,
                                            .lift = static_cast<float>(16 * c.painterly),
                                            .seed = 3}};
            auto next = std::make_unique<Level>(wall.task, 0.035 * (1 << number), scale / (1 << number), o, run);
            next->begin(level.get(), run);
            level = std::move(next);
            for (int round = 0; round < 2; ++round)
                level->paint_round(number < c.levels - 1 && round > 0 ? Round::refines : Round::searches, run);
        }
        const Painting expected = paint(wall.task, *level, texel_faces(wall, c.size), run);
        float worst = 0;
        for (std::size_t i = 0; i < expected.texture.layers[0].values.size(); ++i)
            worst = std::max(worst, std::abs(expected.texture.layers[0].values[i] - whole.texture.layers[0].values[i]));
        CHECK(worst < 1e-3F);
        CHECK(whole.texture.seen == expected.texture.seen);

        const std::pair<const char*, double> told[] = {{"stroke_px", 8 / scale},
                                                       {"picture_width_cm", 56 * 28 * scale / 8},
                                                       {"texel_mm", 1000 / 0.3 / c.size},
                                                       {"searched_texel_mm", 35 * (1 << c.finest)},
                                                       {"searched_texels", level->grid().texels().size()}};
        for (const auto& [key, value] : told)
            CHECK(run.reported.at(key).as_double() == Approx(value));
        CHECK(run.metrics.at("distance").size() == static_cast<std::size_t>(2 * (c.levels - c.finest)));
    }
}

namespace
{

/// As little work as there can be: three rounds at the coarse scale, two at the fine one, and one with strokes of half the width.
struct SmallPainting
{
    WallTask wall{striped(0.25F), 8};
    SynthesisOptions options{
        .size_px = 64, .stroke_m = 0.28, .detail = 1, .patch_px = 5, .rounds_count = 3, .checkpoint_seconds = 1e-9};

    Painting operator()(testing::TestRun& run, const ImageIo* images = nullptr) const
    {
        return fresco::synthesize::synthesize(wall.task, options, images, run);
    }
};

bool are_same(const Painting& a, const Painting& b)
{
    return a.texture.layers == b.texture.layers && a.texture.seen == b.texture.seen && a.source.places == b.source.places &&
           a.source.shifts == b.source.shifts;
}

bool has_line(const testing::TestRun& run, std::string_view text)
{
    return std::ranges::any_of(run.messages, [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "previews are pictures of the painting so far")
{
    SmallPainting small;
    small.options.detail = 0;
    small.options.preview_seconds = 0;
    const stored_png::Codec codec;
    const Painting painted = small(run, &codec);
    const Raster8 preview = codec.read_rgb(run.preview_folder() / "texture.png");
    REQUIRE(preview.width == 64);
    double difference = 0;
    for (std::size_t i = 0; i < preview.values.size(); ++i)
        difference = std::max(difference, std::abs(preview.values[i] - 255 * double{painted.texture.layers[0].values[i]}));
    CHECK(difference <= 0.51);
}

TEST_CASE("a run that is canceled anywhere goes on to the same bytes, with any number of threads")
{
    const SmallPainting small;
    testing::TestRun whole(4);
    const Painting expected = small(whole);
    REQUIRE(whole.metrics.at("distance").size() == 6);
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
            small(run);
        }
        catch (const Canceled&)
        {
            canceled = true;
        }
        const std::size_t rounds = run.metrics["distance"].size();
        run.cancel_after(1 << 30);
        if (!canceled)
            break;
        CHECK(are_same(small(run), expected));
        CHECK(run.metrics["distance"].size() == 6);
        CHECK(has_line(run, "going on after round") == (rounds > 0));
        gone_on += rounds > 0;
    }
    CHECK(gone_on >= 5);
    CHECK(checks > 50);
}

TEST_CASE("a checkpoint that cannot be used is named in a warning, and the run begins again")
{
    SmallPainting small;
    testing::TestRun whole;
    const Painting expected = small(whole);
    testing::TestRun damaged;
    write_file(damaged.checkpoint_folder() / "round.bin", std::vector<std::byte>(100));
    CHECK(are_same(small(damaged), expected));
    CHECK(has_line(damaged, "warning: the checkpoint cannot be used"));
    for (const double seconds : {0.0, 3600.0})
    {
        small.options.checkpoint_seconds = seconds;
        testing::TestRun run;
        small(run);
        CHECK(std::filesystem::is_empty(run.checkpoint_folder()));
    }
}

TEST_CASE_METHOD(testing::StageTest, "a damaged checkpoint is refused by name")
{
    const auto file = folder.path() / "round.bin";
    write_checkpoint(file, {2, 5, {{{3, 0}, 7.25F}, {{3, 1}, 7.25F}}, {1, 2.5F}});
    const std::vector<std::byte> whole = read_file(file);
    const auto is_refused = [&](std::span<const std::byte> bytes)
    {
        write_file(file, bytes);
        return testing::error_of([&] { (void)read_checkpoint(file); }).find(file.string()) != std::string::npos;
    };
    CHECK_FALSE(is_refused(whole));
    for (std::size_t i = 0; i < whole.size(); ++i)
    {
        CAPTURE(i);
        CHECK(is_refused(std::span(whole).first(i)));
        std::vector<std::byte> bytes = whole;
        bytes[i] ^= static_cast<std::byte>(1U << i % 8);
        CHECK(is_refused(bytes));
    }
    std::filesystem::remove(file);
    std::filesystem::create_directory(file);
    CHECK_THROWS_WITH(read_checkpoint(file), Catch::Contains("round.bin"));
}

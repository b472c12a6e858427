#include "catch.h"
#include "plain_synthesis.h"
#include "samples.h"

#include "nearby_uses.h"
#include "synthesis.h"

#include <fresco/images/stroke_width.h>

using namespace samples;

namespace
{

/// Turned in the atlas, so that no point of a patch lies at a texel's center by chance.
struct SmallTask
{
    testing::TestRun run;
    Mesh mesh = turned_wall(0.4, 1);
    PaintedSurface surface{mesh, run};
    Upright upward = upright(surface, Vec3f{0, 1, 0});
    Raster8 picture = brush_picture(56, 48, 11);
    Task task{surface, upward, picture, [](std::uint32_t chart, Vec2f uv, double) {
                  return Vec3f{0.3F + 0.5F * uv.x, 0.4F + 0.1F * static_cast<float>(chart), 0.6F - 0.4F * uv.y};
              }};
};

std::vector<plain::Found> of(const std::vector<Match>& matches)
{
    std::vector<plain::Found> result;
    for (const Match& match : matches)
        result.push_back({{static_cast<double>(match.at.x), static_cast<double>(match.at.y)},
                          static_cast<double>(match.distance),
                          vec_cast<double>(match.shift)});
    return result;
}

std::vector<Vec3d> of(const std::vector<Vec3f>& colors)
{
    std::vector<Vec3d> result;
    for (const Vec3f color : colors)
        result.push_back(vec_cast<double>(color));
    return result;
}

double largest_difference(const std::vector<Vec3f>& a, const std::vector<Vec3d>& b)
{
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, length(vec_cast<double>(a[i]) - b[i]));
    return largest;
}

/// Two places between which rounding may decide, be they a patch's own or continued from around.
bool is_tie(const plain::PlainLevel& twin, const plain::Searched& searched, std::size_t patch, Vec2d a, Vec2d b)
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
void compare_round(Level& level, const plain::PlainLevel& twin, testing::TestRun& run)
{
    const plain::Numbers crowding(level.crowding().begin(), level.crowding().end());
    const plain::Searched expected = twin.search(of(level.colors()), crowding, of(level.matches()));
    level.paint_round(run);
    REQUIRE(level.matches().size() == expected.found.size());
    const auto found = of(level.matches());
    std::size_t elsewhere = 0;
    std::size_t wrong = 0;
    double worst = 0;
    double shift = 0;
    for (std::size_t p = 0; p < found.size(); ++p)
    {
        const plain::Found& own = expected.found[p];
        if (length(found[p].at - own.at) > 2e-3)
        {
            ++elsewhere;
            wrong += !is_tie(twin, expected, p, found[p].at, own.at);
        }
        else
        {
            worst = std::max(worst, std::abs(found[p].distance - own.distance) / (1 + own.distance));
            shift = std::max(shift, length(found[p].shift - own.shift));
        }
    }
    CHECK(wrong <= 1);  // A tie between places that a later pass left.
    CHECK(elsewhere <= found.size() / 50);
    // A point of a patch may round to the next step of 1 / 256 texel.
    CHECK(worst < 5e-3);
    CHECK(shift < 0.02);
    CHECK(largest_difference(level.colors(), twin.voted(found)) < 0.01);
    const plain::Numbers crowded = twin.crowded(crowding, found);
    double farthest = 0;
    for (std::size_t k = 0; k < crowded.size(); ++k)
        farthest = std::max(farthest, std::abs(crowded[k] - static_cast<double>(level.crowding()[k])) / crowded[k]);
    CHECK(farthest < 1e-4);
}

void compare_texture(const Painting& painting, const std::map<std::size_t, plain::PlainLevel::Texel>& expected)
{
    const int size = painting.texture.size_px();
    double worst = 0;
    double farthest = 0;
    double shift = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const auto it =
                expected.find(static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x));
            const auto place = painting.source.place(x, y);
            REQUIRE(painting.texture.seen.at(x, y) == (it != expected.end() ? 1 : 0));
            REQUIRE(place.has_value() == (it != expected.end()));
            if (!place)
                continue;
            const float* rgb = &painting.texture.layers[0].at(x, y);
            const Vec3d color = vec_cast<double>(Vec3f{rgb[0], rgb[1], rgb[2]}) - it->second.rgb;
            worst = std::max({worst, std::abs(color.x), std::abs(color.y), std::abs(color.z)});
            const Vec2d told{std::clamp<double>(it->second.place.x, 0, painting.source.picture_width),
                             std::clamp<double>(it->second.place.y, 0, painting.source.picture_height)};
            shift = std::max(shift, length(vec_cast<double>(place->shift) - it->second.shift));
            farthest =
                std::max(farthest, length(Vec2d{static_cast<double>(place->at.x), static_cast<double>(place->at.y)} - told));
        }
    CHECK(worst < 2e-3);
    CHECK(farthest < 0.02);
    CHECK(shift < 0.01);
}

}  // namespace

TEST_CASE("a whole synthesis is that of a plain twin")
{
    SmallTask small;
    testing::TestRun run;
    const LevelOptions usual{
        .side = 5,
        .stride = 4,
        .faithfulness = 0.27,
        .unrest = 10,
        .least_missing = 0,
        .search = {.completeness = 2, .stroke_px = 8, .variety = 5, .lift = 8, .repeat_cost = 30, .weave_cost = 10, .seed = 0}};
    const LevelOptions other{
        .side = 7,
        .stride = 4,
        .faithfulness = 0.45,
        .unrest = 20,
        .least_missing = 0,
        .search = {
            .completeness = 0.5, .stroke_px = 8, .variety = 40, .lift = 0, .repeat_cost = 80, .weave_cost = 60, .seed = 7}};
    for (const LevelOptions& options : {usual, other})
    {
        const double spacing = 0.035;
        const double scale = 0.9;
        LevelOptions coarse_options = options;
        coarse_options.stride = 3;
        Level coarse(small.task, 2 * spacing, scale / 2, coarse_options, run);
        const plain::PlainLevel plain_coarse(small.task, coarse, coarse_options, scale / 2);
        coarse.begin(nullptr, run);
        CHECK(largest_difference(coarse.colors(), plain_coarse.begin_alone()) < 0.01);
        for (int round = 0; round < 3; ++round)
            compare_round(coarse, plain_coarse, run);

        Level fine(small.task, spacing, scale, options, run);
        const plain::PlainLevel plain_fine(small.task, fine, options, scale);
        REQUIRE(fine.picture().key_count() == plain_fine.picture().keys.size());
        for (std::size_t k = 0; k < fine.picture().key_count(); ++k)
        {
            const Vec2f at = fine.picture().key(k);
            CHECK(Vec2d{static_cast<double>(at.x), static_cast<double>(at.y)} == plain_fine.picture().keys[k]);
        }
        fine.begin(&coarse, run);
        CHECK(largest_difference(fine.colors(), plain_fine.begin_after(plain_coarse, of(coarse.matches()))) < 0.01);
        for (int round = 0; round < 3; ++round)
            compare_round(fine, plain_fine, run);

        for (const int size : {48, 180})
            compare_texture(paint(small.task, fine, size, run), plain_fine.texture(size, of(fine.matches())));
    }
}

TEST_CASE("no round takes a patch from a transparent part of the picture, by whichever step")
{
    SmallTask small;
    testing::TestRun run;
    Task task = small.task;
    task.opaque = Raster8(task.picture.width, task.picture.height, 1, 255);
    for (int y = 0; y < task.opaque.height; ++y)
        for (int x = 0; x < task.opaque.width; ++x)
            if (x % 20 == 0)
                task.opaque.at(x, y) = 0;
    const LevelOptions options{
        .side = 5,
        .stride = 3,
        .faithfulness = 0.5,
        .unrest = 10,
        .least_missing = 0,
        .search = {.completeness = 2, .stroke_px = 8, .variety = 5, .lift = 8, .repeat_cost = 30, .weave_cost = 10, .seed = 0}};
    Level all(small.task, 0.035, 0.9, options, run);
    Level part(task, 0.035, 0.9, options, run);
    std::size_t wrong = 0;
    std::size_t elsewhere = 0;
    for (Level* level : {&all, &part})
    {
        level->begin(nullptr, run);
        for (int round = 0; round < 3; ++round)
        {
            level->paint_round(run);
            for (const Match& match : level->matches())
                (level == &all ? elsewhere : wrong) += !part.picture().has_patch(match.at);
        }
    }
    CHECK(wrong == 0);
    CHECK(elsewhere > 0);
    const std::vector<Match> foreign = all.matches();
    const std::vector<float> crowding(part.picture().key_count(), 1);
    CHECK_THROWS_WITH(part.resume(foreign, crowding, run), Catch::Contains("values that no painting has"));
}

TEST_CASE("uses nearby are those that every patch counts among all others")
{
    SmallTask small;
    testing::TestRun run;
    const LevelOptions options{
        .side = 5,
        .stride = 4,
        .faithfulness = 0.5,
        .unrest = 10,
        .least_missing = 0,
        .search = {.completeness = 2, .stroke_px = 3, .variety = 0, .lift = 0, .repeat_cost = 45, .weave_cost = 8, .seed = 0}};
    Level level(small.task, 0.035, 0.9, options, run);
    level.begin(nullptr, run);
    level.paint_round(run);
    const plain::PlainLevel twin(small.task, level, options, 0.9);
    const NearbyUses uses(level.patches(), level.grid(), level.picture(), 3, run);
    const NearbyUses::Placed placed = uses.placed(level.matches());
    NearbyUses::Map map(uses, placed);
    const NearbyUses::Placed nothing;
    NearbyUses::Map unused(uses, nothing);
    REQUIRE(uses.order().size() == level.patches().count());
    const auto of_all = of(level.matches());
    double most = 0;
    std::size_t wrong = 0;
    for (const std::uint32_t patch : uses.order())
        for (const std::size_t of : {std::size_t{patch}, level.patches().count() / 2, std::size_t{0}})
        {
            map.move_to(patch);
            const Vec2f at = level.matches()[of].at;
            const NearbyUses::Copies found = map.copies(patch, at);
            const auto expected = twin.copies(patch, {double{at.x}, double{at.y}}, of_all);
            wrong += std::abs(double{found.around} - expected.around) > 1e-4 ||
                     std::abs(double{found.beside} - expected.beside) > 1e-4;
            most = std::max(most, expected.around - expected.beside);
            CHECK(unused.copies(patch, at).around == 0);
        }
    CHECK(wrong == 0);
    CHECK(most > 0);
}

TEST_CASE("a synthesis is its levels, with strokes eight texels wide in the finest")
{
    SmallTask small;
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
                                       .completeness = 1.5,
                                       .patch_px = 5,
                                       .levels_count = c.levels,
                                       .rounds_count = 2,
                                       .seed = 3,
                                       .checkpoint_seconds = 10,
                                       .preview_seconds = 5};
        const Painting whole = fresco::synthesize::synthesize(small.task, options, nullptr, run);

        const double scale = 8 / stroke_width_px(small.picture, run);
        std::unique_ptr<Level> level;
        for (int number = c.levels - 1; number >= c.finest; --number)
        {
            const LevelOptions o{.side = 5,
                                 .stride = number > 0 ? 3 : 4,
                                 .faithfulness = c.faithfulness,
                                 .unrest = 20 * c.painterly,
                                 .least_missing = 0,
                                 .search = {.completeness = 1.5,
                                            .stroke_px = std::ldexp(8.0, -number),
                                            .variety = 10 * c.painterly,
                                            .lift = 16 * c.painterly,
                                            .repeat_cost = 60,
                                            .weave_cost = 25,
                                            .seed = 3}};
            auto next = std::make_unique<Level>(small.task, 0.035 * (1 << number), scale / (1 << number), o, run);
            next->begin(level.get(), run);
            level = std::move(next);
            for (int round = 0; round < 2; ++round)
                level->paint_round(run);
        }
        const Painting expected = paint(small.task, *level, c.size, run);
        float worst = 0;
        for (std::size_t i = 0; i < expected.texture.layers[0].values.size(); ++i)
            worst = std::max(worst, std::abs(expected.texture.layers[0].values[i] - whole.texture.layers[0].values[i]));
        CHECK(worst < 1e-3F);
        CHECK(whole.texture.seen == expected.texture.seen);

        const auto told = [&](const char* key) { return run.reported.at(key).as_double(); };
        CHECK(told("stroke_px") == Approx(8 / scale));
        CHECK(told("picture_width_cm") == Approx(56 * 28 * scale / 8));
        CHECK(told("picture_height_cm") == Approx(48 * 28 * scale / 8));
        CHECK(told("texel_mm") == Approx(1000 / 0.3 / c.size));
        CHECK(told("searched_texel_mm") == Approx(35 * (1 << c.finest)));
        CHECK(told("searched_texels") == static_cast<double>(level->grid().texels().size()));
        CHECK(told("patches") == static_cast<double>(level->patches().count()));
        CHECK(told("keys") == static_cast<double>(level->picture().key_count()));
        CHECK(run.metrics.at("distance").size() == static_cast<std::size_t>(2 * (c.levels - c.finest)));
    }
}

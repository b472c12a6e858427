#include "catch.h"
#include "levels.h"
#include "schedule.h"

#include <fresco/numerics/noise.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

using namespace fresco;
using namespace fresco::optimize;

namespace
{

constexpr double quarter = 0.25;  // R = 128 d

LevelRules rules_with(double angle_limit_deg, Protocol protocol = Protocol::paper, bool by_depth = false)
{
    return {protocol, by_depth, quarter, angle_limit_deg, GradientScaling::angle};
}
const LevelRules by_depth = rules_with(90, Protocol::paper, true);

Raster<double> depth_of(const UvMap& map)
{
    Raster<double> depth(map.depth.width, map.depth.height);
    std::copy(map.depth.values.begin(), map.depth.values.end(), depth.values.begin());
    return depth;
}

UvMap flat_map(int width, int height, float depth, float cosine)
{
    return {RasterF(width, height, 2, 0.5F), RasterF(width, height, 1, depth), RasterF(width, height, 1, cosine),
            Raster8(width, height, 1, 1)};
}

}  // namespace

TEST_CASE("a depth below, above, on and between heights goes to the levels that the pyramid has for it")
{
    const std::vector<int> heights{256, 432, 608, 784};
    struct Case
    {
        double ideal;
        std::size_t first, second;
        double weight;
    };
    for (const Case& c : {Case{100, 0, 0, 1}, Case{900, 3, 3, 1}, Case{608, 2, 2, 1}, Case{300, 0, 1, 0.75},
                          Case{388, 1, 0, 0.75}, Case{344, 0, 1, 0.5},  // as near to both: the lower
                          Case{740, 3, 2, 0.75}, Case{784.5, 3, 3, 1}})
    {
        CAPTURE(c.ideal);
        const auto found = level_choice(c.ideal / 128, heights, quarter);
        CHECK(found.first == c.first);
        CHECK(found.second == c.second);
        CHECK(found.first_weight == Approx(c.weight));
    }
    // Half the length asks for twice the height.
    CHECK(level_choice(300.0 / 256, heights, 0.125).first_weight == Approx(0.75));
}

TEST_CASE("depth levels: union eroded for the masks, weights eroded per role, both resampled by nearest neighbor")
{
    // Two heights, 8 and 16 px; R = 128 d. Columns 0..5 lie at R = 10 (level 0: 0.75, level 1: 0.25), the rest at R = 14 (level
    // 1: 0.75, level 0: 0.25): every pixel belongs to both, in different roles.
    std::vector<UvMap> maps{flat_map(12, 8, 10.0F / 128, 0.5F), flat_map(24, 16, 1, 0.5F)};
    for (int y = 0; y < 8; ++y)
        for (int x = 6; x < 12; ++x)
            maps[0].depth.at(x, y) = 14.0F / 128;
    maps[1].valid.at(10, 8) = 0;
    const auto levels = levels_of(maps, depth_of(maps[0]), by_depth);
    REQUIRE(levels.size() == 2);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 12; ++x)
        {
            CAPTURE(x, y);
            const bool inside = x > 0 && y > 0 && x < 11 && y < 7;
            const bool at_seam = x == 5 || x == 6;
            CHECK(levels[0].all.at(x, y) == (inside ? 1 : 0));
            const double share = !inside || at_seam ? 0 : x < 6 ? 0.75 : 0.25;
            CHECK(levels[0].weight.at(x, y) == Approx(share));
            if (2 * x == 10 && 2 * y == 8)
                continue;
            CHECK(levels[1].all.at(2 * x, 2 * y) == (inside ? 1 : 0));
            CHECK(levels[1].weight.at(2 * x + 1, 2 * y + 1) == Approx(!inside || at_seam ? 0 : 1 - share));
        }
    // Every angle passes, but only in the level's own pixels.
    for (const auto& level : levels)
        CHECK(level.fine == level.all);
    CHECK(levels[1].all.at(10, 8) == 0);
    CHECK(levels[1].all.at(11, 8) == 1);
    const auto shares = level_shares(levels);
    CHECK(shares[0] + shares[1] == Approx(1));
    CHECK(shares[0] == Approx(60.0 / 96 / (60.0 / 96 + 239.0 / 384)));
}

TEST_CASE("the released levels take corners, do not ask for a surface of their own, and erode what lies beyond with both roles")
{
    // As above, but the rest lies beyond the pyramid.
    std::vector<UvMap> maps{flat_map(12, 8, 10.0F / 128, 0.5F), flat_map(29, 20, 1, 0.5F)};
    maps[1].valid.at(10, 8) = 0;
    const int heights[] = {8, 20};
    for (int y = 0; y < 8; ++y)
        for (int x = 6; x < 12; ++x)
            maps[0].depth.at(x, y) = 40.0F / 128;
    const auto paper = levels_of(maps, depth_of(maps[0]), by_depth);
    const auto released = levels_of(maps, depth_of(maps[0]), rules_with(90, Protocol::released_scannet, true));
    const double near_share = level_choice(10.0 / 128, heights, quarter).first_weight;
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 29; ++x)
        {
            CAPTURE(x, y);
            const int column = x * 12 / 29;
            const int row = y * 8 / 20;
            const bool inside = column > 0 && row > 0 && column < 11 && row < 7;
            CHECK(released[1].all.at(x, y) == (inside ? 1 : 0));
            // Beyond the pyramid a pixel has both roles: between the halves, only the first one is eroded.
            CHECK(released[1].weight.at(x, y) == Approx(!inside || column == 6 ? 0 : column < 6 ? 1 - near_share : 1));
        }
    CHECK(paper[1].all.at(10, 8) == 0);
    CHECK(paper[1].weight.at(5 * 29 / 12 + 1, 10) == 0);
    // Two pixels look up five, and five look up two.
    CHECK((corner_pixel(0, 2, 5) == 0 && corner_pixel(1, 2, 5) == 2 && corner_pixel(4, 5, 2) == 1 && corner_pixel(2, 5, 2) == 0));
    // Without levels: the pixels with depth, but everybody's gradient.
    Raster<double> holes = depth_of(maps[0]);
    holes.at(3, 3) = 0;
    const auto whole = levels_of(maps, holes, rules_with(90, Protocol::released_scannet));
    CHECK((whole[0].all.at(3, 3) == 0 && whole[0].weight.at(3, 3) == 1 && whole[1].all.at(8, 8) == 0));
    CHECK(gradient_factor(maps[0], whole[0], GradientScaling::none).at(3, 3) == 1);
}

TEST_CASE("a pixel on a height belongs only to that level, one without depth to none")
{
    std::vector<UvMap> maps{flat_map(8, 8, 8.0F / 128, 1), flat_map(16, 16, 1, 1)};
    const auto on = levels_of(maps, depth_of(maps[0]), by_depth);
    CHECK((on[0].count() == 36 && on[1].count() == 0 && level_shares(on)[1] == 0));
    const auto none = levels_of(maps, Raster<double>(8, 8), by_depth);
    CHECK(none[0].count() + none[1].count() == 0);
}

TEST_CASE("the angle filter takes a level's own cosines, or the smallest height's enlarged; the limit passes or not")
{
    std::vector<UvMap> maps{flat_map(4, 4, 1, 0.9F), flat_map(8, 8, 1, 0.9F)};
    const double limit_deg = 60;
    const auto on_limit = static_cast<float>(std::cos(limit_deg * std::numbers::pi / 180));
    maps[1].cosine.at(3, 3) = 0.2F;
    maps[0].cosine.at(0, 0) = 0.2F;
    maps[0].cosine.at(3, 3) = std::nextafter(on_limit, 1.0F);
    const auto own = levels_of(maps, depth_of(maps[0]), rules_with(limit_deg, Protocol::paper));
    CHECK(own[0].fine.at(0, 0) == 0);
    CHECK(own[0].fine.at(3, 3) == 1);
    CHECK(own[1].fine.at(3, 3) == 0);
    CHECK(own[1].fine.at(0, 0) == 1);
    CHECK(own[1].all.at(3, 3) == 1);
    const auto smallest = levels_of(maps, depth_of(maps[0]), rules_with(limit_deg, Protocol::released_scannet));
    CHECK(smallest[1].fine.at(3, 3) == 1);
    CHECK(smallest[1].fine.at(0, 0) == 0);
    CHECK(gradient_factor(maps[1], smallest[1], GradientScaling::angle).at(0, 0) == Approx(0.2));
    CHECK(gradient_factor(maps[1], own[1], GradientScaling::angle).at(0, 0) == Approx(0.9));
    // The angles are enlarged, not the cosines: a quarter of the way from 25.8° to 78.5° is 39.0°; the mean of the cosines would
    // be that of 43.5°.
    const auto between = levels_of(maps, depth_of(maps[0]), rules_with(41, Protocol::released_scannet));
    CHECK(between[1].fine.at(2, 0) == 1);
    CHECK(between[1].fine.at(1, 0) == 0);
    // Exactly on the limit: cos 90° = 0 passes "at most", not "below".
    maps[0].cosine.at(1, 1) = 0;
    CHECK(levels_of(maps, depth_of(maps[0]), rules_with(90, Protocol::paper))[0].fine.at(1, 1) == 1);
    CHECK(levels_of(maps, depth_of(maps[0]), rules_with(90, Protocol::released_scannet))[0].fine.at(1, 1) == 0);
}

TEST_CASE("gradients are scaled by the level's share and the cosine, or not at all")
{
    std::vector<UvMap> maps{flat_map(8, 8, 10.0F / 128, 0.5F), flat_map(16, 16, 1, 0.25F)};
    maps[1].valid.at(5, 5) = 0;
    const auto levels = levels_of(maps, depth_of(maps[0]), by_depth);
    const auto angle = gradient_factor(maps[1], levels[1], GradientScaling::angle);
    CHECK(angle.at(8, 8) == Approx(0.25 * 0.25));
    CHECK(angle.at(0, 0) == 0);
    CHECK(gradient_factor(maps[1], levels[1], GradientScaling::level).at(8, 8) == Approx(0.25));
    const auto none = gradient_factor(maps[1], levels[1], GradientScaling::none);
    CHECK(none.at(8, 8) == 1);
    CHECK(none.at(0, 0) == 0);
    CHECK(none.at(5, 5) == 0);
}

namespace
{

/// Adds 1 to the pixels of a box.
void add(Raster8& counts, const PixelBox& box)
{
    for (int y = std::max(0, box.y0); y < std::min(counts.height, box.y1); ++y)
        for (int x = std::max(0, box.x0); x < std::min(counts.width, box.x1); ++x)
            ++counts.at(x, y);
}

}  // namespace

TEST_CASE("a full mask is one frame, an empty one nothing, a half one half")
{
    const PixelBox frame{0, 0, 50, 30};
    const auto full = covering_crops(Raster8(50, 30, 1, 1), {8, 3});
    REQUIRE(full.size() == 1);
    CHECK((full[0].core == frame));
    CHECK((full[0].encoded == frame));
    CHECK(covering_crops(Raster8(50, 30), {8, 3}).empty());
    Raster8 left(50, 30);
    add(left, {0, 0, 20, 30});
    const auto half = covering_crops(left, {8, 3});
    REQUIRE(half.size() == 1);
    CHECK((half[0].core == PixelBox{0, 0, 24, 30}));
    CHECK((half[0].encoded == PixelBox{0, 0, 32, 30}));
    // Two corners are two crops, unless a crop is as dear as what lies between them.
    Raster8 corners(200, 200);
    corners.at(0, 0) = corners.at(199, 199) = 1;
    CHECK(covering_crops(corners, {8, 3}).size() == 2);
    CHECK(covering_crops(corners, {8, 3, 40000}).size() == 1);
}

TEST_CASE("cores hold every pixel of the mask once, aligned, and with their margin inside what is encoded")
{
    for (std::uint32_t seed = 0; seed < 30; ++seed)
    {
        CAPTURE(seed);
        const int width = 40 + static_cast<int>(seed) * 3;
        const int height = 33 + static_cast<int>(seed % 7) * 5;
        Raster8 mask(width, height);
        for (std::uint32_t blob = 0; blob < 4; ++blob)
        {
            const int cx = static_cast<int>(noise::unit(seed, 10 * blob) * static_cast<float>(width));
            const int cy = static_cast<int>(noise::unit(seed, 10 * blob + 1) * static_cast<float>(height));
            const int radius = static_cast<int>(noise::unit(seed, 10 * blob + 2) * 8);
            add(mask, {cx - radius, cy - radius, cx + radius + 1, cy + radius + 1});
        }
        const int align = seed % 2 == 0 ? 4 : 8;
        const int margin = static_cast<int>(seed % 11);
        const auto crops = covering_crops(mask, {align, margin, seed % 3 == 0 ? 0 : 50});
        Raster8 counts(width, height);  // How often each pixel is in a core.
        std::int64_t encoded = 0;
        for (const auto& [core, box] : crops)
        {
            add(counts, core);
            encoded += box.area();
            for (const auto& [begin, end, whole, outer_begin, outer_end] :
                 {std::array{core.x0, core.x1, width, box.x0, box.x1}, std::array{core.y0, core.y1, height, box.y0, box.y1}})
            {
                CHECK(begin % align == 0);
                CHECK((end % align == 0 || end == whole));
                CHECK(outer_begin % align == 0);
                CHECK((outer_begin == 0 || begin - outer_begin >= margin));
                CHECK((outer_end == whole || outer_end - end >= margin));
            }
        }
        CHECK(encoded <= static_cast<std::int64_t>(width) * height);
        for (std::size_t i = 0; i < counts.values.size(); ++i)
            CHECK((counts.values[i] == 1 || (counts.values[i] == 0 && mask.values[i] == 0)));
    }
}

namespace
{

Schedule scheduled(std::size_t count, const ScheduleOptions& options)
{
    std::vector<std::size_t> views(count);
    std::iota(views.begin(), views.end(), std::size_t{10});
    return {std::move(views), 0, options};
}

}  // namespace

TEST_CASE("repeats are consecutive and every epoch visits every view")
{
    ScheduleOptions o;
    o.epochs = 3;
    o.repeats_count = 4;
    for (const bool shuffled : {false, true})
    {
        o.shuffled = shuffled;
        const Schedule schedule = scheduled(5, o);
        REQUIRE(schedule.steps() == 60);
        REQUIRE(schedule.visits() == 15);
        for (std::int64_t epoch = 0; epoch < 3; ++epoch)
        {
            std::multiset<std::size_t> seen;
            for (std::int64_t step = epoch * 20; step < epoch * 20 + 20; ++step)
            {
                const auto at = schedule.at(step);
                CHECK(at.epoch == epoch);
                CHECK(at.repeat == step % 4);
                CHECK(at.visit == static_cast<std::size_t>(step / 4));
                CHECK(at.view == schedule.view_of_visit(at.visit));
                seen.insert(at.view);
            }
            for (std::size_t view = 10; view < 15; ++view)
                CHECK(seen.count(view) == 4);
        }
    }
    o.shuffled = false;
    CHECK(scheduled(5, o).at(21).view == 10);
    CHECK(scheduled(5, o).at(7).view == 11);
    // Within a visit.
    o.max_steps = 7;
    CHECK((scheduled(5, o).steps() == 7 && scheduled(5, o).visits() == 2));
}

TEST_CASE("the spread order is a permutation whose beginnings cover the recording")
{
    for (const std::size_t count : {1U, 2U, 3U, 4U, 6U, 12U, 125U, 1000U})
        for (std::uint64_t seed = 0; seed < 5; ++seed)
        {
            std::set<std::size_t> seen;
            for (std::size_t i = 0; i < count; ++i)
                seen.insert(spread_index(i, count, seed));
            CHECK(seen.size() == count);
            CHECK(*seen.rbegin() == count - 1);
        }
    // A tenth of the walk leaves no gap of more than a quarter of the recording.
    std::set<std::size_t> first;
    for (std::size_t i = 0; i < 12; ++i)
        first.insert(spread_index(i, 125, 7));
    std::size_t last = 0;
    for (const auto index : first)
    {
        CHECK(index - last <= 31);
        last = index;
    }
}

TEST_CASE("learning rates by hand")
{
    ScheduleOptions o;
    o.epochs = 10;
    o.rate = 2;
    const Schedule cosine = scheduled(10, o);
    CHECK(cosine.rate(0) == 2);
    CHECK(cosine.rate(50) == 2);
    CHECK(cosine.rate(75) == Approx(1));
    CHECK(cosine.rate(99) > 0);
    CHECK(cosine.rate(99) < 0.01);
    o.decay_start = 1;
    CHECK(scheduled(10, o).rate(99) == 2);
    o.decay = Decay::step;
    const Schedule steps = scheduled(10, o);
    CHECK(steps.rate(29) == 2);
    CHECK(steps.rate(30) == Approx(0.2));
    CHECK(steps.rate(99) == Approx(0.002));
}

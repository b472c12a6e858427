#include "catch.h"
#include "exposure.h"

#include <fresco/random.h>

#include <cmath>

using namespace fresco;
using namespace fresco::from_frames;

namespace
{

struct World
{
    std::vector<std::vector<CellColor>> views;
    std::vector<Gain> brightness;  ///< What each view's picture was multiplied by.
};

/// Views along a wall of 400 cells: view v sees cells 40 v to 40 v + 120, multiplied by factors whose logarithms sum to 0.
World wall(std::size_t count, double noise)
{
    Random random(17);
    World world;
    world.views.resize(count);
    std::vector<Gain> colors(400);
    for (auto& color : colors)
        for (auto& value : color)
            value = 0.2 + 0.5 * random.uniform();
    for (std::size_t v = 0; v < count; ++v)
    {
        const double sign = v % 2 == 0 ? 1 : -1;
        const double part = v + 1 == count && count % 2 == 1 ? 0 : 0.05 * static_cast<double>(v / 2 + 1);
        world.brightness.push_back({std::exp(sign * part), std::exp(-sign * part / 2), std::exp(sign * part / 4)});
        for (std::uint32_t cell = 40 * static_cast<std::uint32_t>(v); cell < 40 * v + 120; ++cell)
        {
            CellColor seen{cell, 1, {}};
            for (std::size_t c = 0; c < 3; ++c)
                seen.log_rgb[c] =
                    static_cast<float>(std::log(colors[cell][c] * world.brightness[v][c]) + noise * random.normal());
            world.views[v].push_back(seen);
        }
    }
    return world;
}

void check_gains(const World& world, double tolerance)
{
    const auto gains = exposure_gains(world.views, 400, Progress());
    for (std::size_t v = 0; v < world.views.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c)
        {
            CAPTURE(v, c);
            CHECK(gains[v][c] * world.brightness[v][c] == Approx(1).epsilon(tolerance));
        }
}

}  // namespace

TEST_CASE("factors that pictures were multiplied by are found, to 1 %")
{
    check_gains(wall(7, 0), 0.002);
    check_gains(wall(7, 0.03), 0.01);
}

TEST_CASE("highlights and what stands in front do not spoil the factors")
{
    World world = wall(7, 0.01);
    for (std::size_t v = 0; v < 7; v += 2)
        for (std::size_t i = 0; i < 30; ++i)
            world.views[v][i].log_rgb = {-0.1F, -0.1F, -0.1F};
    check_gains(world, 0.01);
}

TEST_CASE("views that share nothing keep their exposure, and every group keeps its mean")
{
    World world = wall(4, 0);
    for (auto& view : world.views)  // Views 0 and 1 see each other; 2 and 3 see cells far away.
        for (auto& color : view)
            if (&view == &world.views[2] || &view == &world.views[3])
                color.cell += 150;
    world.views.push_back({{5, 1, {-1, -1, -1}}});
    world.views.push_back({});
    world.views.back().push_back({399, 1, {-2, -2, -2}});
    world.views[4][0].cell = 398;
    const auto gains = exposure_gains(world.views, 400, Progress());
    for (std::size_t c = 0; c < 3; ++c)
    {
        CHECK(gains[4][c] == Approx(1));
        CHECK(gains[5][c] == Approx(1));
        CHECK(std::log(gains[0][c]) + std::log(gains[1][c]) == Approx(0).margin(1e-9));
        CHECK(std::log(gains[2][c]) + std::log(gains[3][c]) == Approx(0).margin(1e-9));
        CHECK(gains[0][c] / gains[1][c] == Approx(world.brightness[1][c] / world.brightness[0][c]).epsilon(0.002));
    }
}

TEST_CASE("cells that are nearly black or saturated say nothing, and all views choose the same of too many")
{
    SampleBlocks samples(2);
    samples[1].push_back({9, 0.5F, {0.5F, 0.25F, 0.1F}});
    samples[0].push_back({3, 1, {0.5F, 0.5F, 0.02F}});
    samples[0].push_back({4, 1, {0.5F, 0.99F, 0.5F}});
    const auto colors = cell_colors(samples);
    REQUIRE(colors.size() == 1);
    CHECK(colors[0].cell == 9);
    CHECK(colors[0].weight == 0.5F);
    CHECK(colors[0].log_rgb[1] == Approx(std::log(0.25)));

    SampleBlocks many(1);
    SampleBlocks half(1);
    for (std::uint32_t cell = 0; cell < 20000; ++cell)
    {
        many[0].push_back({cell, 1, {0.5F, 0.5F, 0.5F}});
        if (cell < 10000)
            half[0].push_back(many[0].back());
    }
    const auto of_many = cell_colors(many);
    const auto of_half = cell_colors(half);
    CHECK(of_many.size() == 4096);
    CHECK(of_half.size() == 4096);
    std::size_t shared = 0;
    for (const auto& color : of_many)
        shared += std::any_of(of_half.begin(), of_half.end(), [&](const CellColor& other) { return other.cell == color.cell; });
    const auto below = std::count_if(of_many.begin(), of_many.end(), [](const CellColor& c) { return c.cell < 10000; });
    CHECK(static_cast<std::ptrdiff_t>(shared) == below);
    CHECK(below > 1800);
    CHECK(below < 2300);
    CHECK(std::is_sorted(of_many.begin(), of_many.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; }));
}

#include "catch.h"
#include "exposure.h"
#include "shared_data.h"

#include <fresco/frames.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include "raw_images.h"

#include <algorithm>
#include <cmath>
#include <map>

using namespace fresco;
using namespace fresco::from_frames;

namespace
{

using Log = std::array<double, 3>;

struct World
{
    std::vector<std::vector<CellColor>> views;
    std::vector<Log> brightness;  ///< Logarithms of what each view's picture was multiplied by.
};

/// Views along a wall of cells: view v sees cells 40 v to 40 v + 120 from left to right.
World wall(std::size_t count, double noise, const std::function<Log(std::size_t)>& brightness)
{
    Random random(17);
    World world;
    world.views.resize(count);
    std::vector<Log> colors(40 * count + 120);
    for (auto& color : colors)
        for (auto& value : color)
            value = std::log(0.2 + 0.5 * random.uniform());
    for (std::size_t v = 0; v < count; ++v)
    {
        world.brightness.push_back(brightness(v));
        for (std::uint32_t i = 0; i < 120; ++i)
        {
            const std::uint32_t cell = 40 * static_cast<std::uint32_t>(v) + i;
            CellColor seen{cell, 1, {}, {(static_cast<float>(i) + 0.5F) / 120, 0.5F}};
            for (std::size_t c = 0; c < 3; ++c)
                seen.log_rgb[c] = static_cast<float>(colors[cell][c] + world.brightness[v][c] + noise * random.normal());
            world.views[v].push_back(seen);
        }
    }
    return world;
}

std::vector<Gains> gains_of(const World& world)
{
    return exposure_gains(world.views, 40 * world.views.size() + 120, testing::TestRun(2));
}

Log log_gain(const Gains& gains, float x)
{
    const auto gain = gain_at(gains, {x, 0.5F});
    return {std::log(double{gain[0]}), std::log(double{gain[1]}), std::log(double{gain[2]})};
}

/// Over the picture.
double mean_log_gain(const Gains& gains, std::size_t channel)
{
    double sum = 0;
    for (const float x : {0.1F, 0.3F, 0.5F, 0.7F, 0.9F})
        sum += log_gain(gains, x)[channel] / 5;
    return sum;
}

Log by_turns(std::size_t v)
{
    const double sign = v % 2 == 0 ? 1 : -1;
    const double part = sign * 0.05 * static_cast<double>(v % 5 + 1);
    return {part, -part / 2, part / 4};
}

}  // namespace

TEST_CASE("factors that pictures were multiplied by are found, also behind highlights and what stands in front")
{
    for (const double noise : {0.0, 0.03})
        for (const bool disturbed : {false, true})
        {
            World world = wall(8, noise, by_turns);
            for (std::size_t v = 0; disturbed && v < 8; v += 2)
                for (std::size_t i = 0; i < 30; ++i)
                    world.views[v][i].log_rgb = {-0.1F, -0.1F, -0.1F};
            const auto gains = gains_of(world);
            for (std::size_t v = 0; v + 1 < 8; ++v)
                for (std::size_t c = 0; c < 3; ++c)
                {
                    CAPTURE(noise, disturbed, v, c);
                    const double step = world.brightness[v + 1][c] - world.brightness[v][c];
                    CHECK(mean_log_gain(gains[v], c) - mean_log_gain(gains[v + 1], c) ==
                          Approx(step).margin(0.15 * std::abs(step) + 0.02));
                }
        }
}

TEST_CASE("small errors do not add up along a chain of views")
{
    // Each view is 3 % brighter at its right than at its left, which the next one takes for exposure.
    World world = wall(60, 0, [](std::size_t) { return Log{}; });
    for (auto& view : world.views)
        for (CellColor& color : view)
            for (float& value : color.log_rgb)
                value += 0.03F * (color.at[0] - 0.5F);
    double most = 0;
    for (const Gains& gains : gains_of(world))
        most = std::max(most, std::abs(mean_log_gain(gains, 0)));
    CHECK(most < 0.1);  // Unanchored, 60 views add up to 0.3 from the middle to either end.
}

TEST_CASE("vignetting is leveled, and views that share nothing keep their colors")
{
    World world = wall(6, 0, [](std::size_t) { return Log{}; });
    for (auto& view : world.views)
        for (CellColor& color : view)
            for (float& value : color.log_rgb)
                value -= 1.2F * (color.at[0] - 0.5F) * (color.at[0] - 0.5F);
    world.views.push_back({{399, 1, {-1, -1, -1}, {0.5F, 0.5F}}});
    const auto gains = gains_of(world);
    for (std::size_t v = 1; v < 5; ++v)
        CHECK(log_gain(gains[v], 0.95F)[1] - log_gain(gains[v], 0.5F)[1] == Approx(1.2 * 0.45 * 0.45).epsilon(0.4));
    CHECK(log_gain(gains[6], 0.5F)[0] == 0);
    const auto groups = overlapping_groups(world.views, 400);
    CHECK(groups == std::vector<std::uint32_t>{0, 0, 0, 0, 0, 0, 6});
}

TEST_CASE("cells that are nearly black or saturated say nothing, and all views choose the same of too many")
{
    const std::vector<TexelSample> samples{
        {3, 1, {0.5F, 0.5F, 0.02F}, {}}, {4, 1, {0.5F, 0.99F, 0.5F}, {}}, {9, 0.5F, {0.5F, 0.25F, 0.1F}, {0.25F, 0.75F}}};
    const auto colors = cell_colors(samples, 512);
    REQUIRE(colors.size() == 1);
    CHECK(colors[0].cell == 9);
    CHECK(colors[0].log_rgb[1] == Approx(std::log(0.25)));
    CHECK(colors[0].at[1] == 0.75F);

    std::vector<TexelSample> many;
    for (std::uint32_t cell = 0; cell < 512 * 64; ++cell)
        many.push_back({cell, 1, {0.5F, 0.5F, 0.5F}, {}});
    const auto of_many = cell_colors(many, 512);
    many.resize(512 * 32);
    const auto of_half = cell_colors(many, 512);
    CHECK(of_many.size() == Approx(4096).margin(64));
    CHECK(of_half.size() == Approx(4096).margin(64));
    CHECK(std::ranges::is_sorted(of_many, {}, &CellColor::cell));
    std::map<std::uint32_t, int> squares;
    for (const CellColor& color : of_many)
        ++squares[color.cell / 512 / 8 * 64 + color.cell % 512 / 8];
    for (const auto& [square, count] : squares)
        CHECK(count == 64);
    for (const CellColor& color : of_many)
        if (color.cell < 512 * 32)
            CHECK(std::ranges::any_of(of_half, [&](const CellColor& other) { return other.cell == color.cell; }));
}

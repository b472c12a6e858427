#include "levels.h"

#include <fresco/math.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace fresco::optimize
{
namespace
{

/// Number of the pixel of `from` that lies under the middle of pixel `i` of `to`.
int nearest(int i, int to, int from)
{
    return static_cast<int>((2 * static_cast<std::int64_t>(i) + 1) * from / (2 * static_cast<std::int64_t>(to)));
}

template <class T>
Raster<T> nearest_resized(const Raster<T>& raster, int width, int height)
{
    if (raster.width == width && raster.height == height)
        return raster;
    Raster<T> result(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            result.at(x, y) = raster.at(nearest(x, width, raster.width), nearest(y, height, raster.height));
    return result;
}

/// Where a level is the first or the second choice of a pixel of the smallest height, and its share there.
struct Roles
{
    Raster8 first;
    Raster8 second;
    RasterF share;
};

std::vector<Roles> assigned_roles(const RasterF& depth, std::span<const int> heights, const DepthRule& rule)
{
    const Roles none{Raster8(depth.width, depth.height), Raster8(depth.width, depth.height), RasterF(depth.width, depth.height)};
    std::vector<Roles> roles(heights.size(), none);
    for (std::size_t i = 0; i < depth.values.size(); ++i)
    {
        if (!(depth.values[i] > 0))
            continue;
        const auto choice = level_choice(depth.values[i], heights, rule);
        roles[choice.first].first.values[i] = 1;
        roles[choice.first].share.values[i] = static_cast<float>(choice.first_weight);
        if (choice.second == choice.first || !(choice.first_weight < 1))
            continue;
        roles[choice.second].second.values[i] = 1;
        roles[choice.second].share.values[i] = static_cast<float>(1 - choice.first_weight);
    }
    return roles;
}

/// The level of the smallest height's pixels: `all` eroded after the union of the roles, the weight per role.
LevelPixels eroded_level(Roles roles)
{
    Raster8 either = roles.first;
    for (std::size_t i = 0; i < either.values.size(); ++i)
        either.values[i] |= roles.second.values[i];
    LevelPixels level{eroded(either), {}, std::move(roles.share), {}};
    const Raster8 first = eroded(roles.first);
    const Raster8 second = eroded(roles.second);
    for (std::size_t i = 0; i < level.weight.values.size(); ++i)
        if (first.values[i] == 0 && second.values[i] == 0)
            level.weight.values[i] = 0;
    return level;
}

void keep_valid(LevelPixels& level, const Raster8& valid)
{
    for (std::size_t i = 0; i < valid.values.size(); ++i)
        if (valid.values[i] == 0)
        {
            level.all.values[i] = 0;
            level.weight.values[i] = 0;
        }
}

RasterF degrees(const RasterF& cosine)
{
    RasterF result = cosine;
    for (auto& value : result.values)
        value = static_cast<float>(std::acos(std::clamp(static_cast<double>(value), 0.0, 1.0)) * 180 / std::numbers::pi);
    return result;
}

/// Whether a pixel passes, by its angle in degrees.
bool passes(double angle_deg, const AngleRule& rule)
{
    return rule.below ? angle_deg < rule.limit_deg : angle_deg <= rule.limit_deg;
}

void filter_by_angle(LevelPixels& level, const UvMap& map, const UvMap& smallest, const AngleRule& rule)
{
    RasterF angles = degrees(map.cosine);
    if (rule.from_smallest && map.cosine.width != smallest.cosine.width)
    {
        // The angles themselves are enlarged for the filter, the cosines for the scaling.
        angles = resized(degrees(smallest.cosine), map.cosine.width, map.cosine.height);
        level.cosine = resized(smallest.cosine, map.cosine.width, map.cosine.height);
    }
    level.fine = level.all;
    for (std::size_t i = 0; i < level.fine.values.size(); ++i)
        if (!passes(static_cast<double>(angles.values[i]), rule))
            level.fine.values[i] = 0;
}

}  // namespace

LevelChoice level_choice(double depth_m, std::span<const int> heights_px, const DepthRule& rule)
{
    const double ideal = rule.theta_min_px * depth_m / rule.theta_d_m;
    std::size_t first = 0;
    for (std::size_t i = 1; i < heights_px.size(); ++i)
        if (std::abs(ideal - heights_px[i]) < std::abs(ideal - heights_px[first]))
            first = i;
    const double height = heights_px[first];
    const bool above = ideal > height;
    if (ideal == height || (above ? first + 1 == heights_px.size() : first == 0))
        return {first, first, 1};
    const std::size_t second = above ? first + 1 : first - 1;
    const double way = std::abs(ideal - height) / std::abs(height - heights_px[second]);
    return {first, second, rule.printed_weight ? way : 1 - way};
}

std::int64_t LevelPixels::count() const
{
    return std::count_if(all.values.begin(), all.values.end(), [](auto v) { return v != 0; });
}

Raster8 eroded(const Raster8& mask)
{
    const auto and_three = [](std::uint8_t a, std::uint8_t b, std::uint8_t c) { return static_cast<std::uint8_t>(a & b & c); };
    Raster8 across(mask.width, mask.height);
    for (int y = 0; y < mask.height; ++y)
        for (int x = 1; x + 1 < mask.width; ++x)
            across.at(x, y) = and_three(mask.at(x - 1, y), mask.at(x, y), mask.at(x + 1, y));
    Raster8 result(mask.width, mask.height);
    for (int y = 1; y + 1 < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
            result.at(x, y) = and_three(across.at(x, y - 1), across.at(x, y), across.at(x, y + 1));
    return result;
}

std::vector<LevelPixels> whole_levels(std::span<const UvMap> maps, const AngleRule& angle)
{
    std::vector<LevelPixels> levels;
    for (const auto& map : maps)
    {
        LevelPixels level{map.valid, {}, RasterF(map.valid.width, map.valid.height), {}};
        std::transform(map.valid.values.begin(), map.valid.values.end(), level.weight.values.begin(),
                       [](auto valid) { return valid != 0 ? 1.0F : 0.0F; });
        filter_by_angle(level, map, maps[0], angle);
        levels.push_back(std::move(level));
    }
    return levels;
}

std::vector<LevelPixels> depth_levels(std::span<const UvMap> maps, const RasterF& depth, const DepthRule& rule,
                                      const AngleRule& angle)
{
    std::vector<int> heights;
    for (const auto& map : maps)
        heights.push_back(map.valid.height);
    auto roles = assigned_roles(depth, heights, rule);
    std::vector<LevelPixels> levels;
    for (std::size_t i = 0; i < maps.size(); ++i)
    {
        const LevelPixels small = eroded_level(std::move(roles[i]));
        const auto& valid = maps[i].valid;
        LevelPixels level{nearest_resized(small.all, valid.width, valid.height),
                          {},
                          nearest_resized(small.weight, valid.width, valid.height),
                          {}};
        keep_valid(level, valid);
        filter_by_angle(level, maps[i], maps[0], angle);
        levels.push_back(std::move(level));
    }
    return levels;
}

std::vector<double> level_shares(std::span<const LevelPixels> levels)
{
    std::vector<double> shares;
    double sum = 0;
    for (const auto& level : levels)
    {
        shares.push_back(level.all.empty() ? 0.0
                                           : static_cast<double>(level.count()) / static_cast<double>(level.all.values.size()));
        sum += shares.back();
    }
    for (auto& share : shares)
        share = sum > 0 ? share / sum : 0;
    return shares;
}

RasterF gradient_factor(const UvMap& map, const LevelPixels& pixels, GradientScaling scaling)
{
    RasterF factor = pixels.weight;
    const RasterF& cosine = pixels.cosine.empty() ? map.cosine : pixels.cosine;
    for (std::size_t i = 0; i < factor.values.size(); ++i)
        if (scaling == GradientScaling::angle)
            factor.values[i] *= cosine.values[i];
        else if (scaling == GradientScaling::none)
            factor.values[i] = pixels.all.values[i] != 0 ? 1.0F : 0.0F;
    return factor;
}

}  // namespace fresco::optimize

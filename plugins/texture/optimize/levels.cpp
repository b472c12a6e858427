#include "levels.h"

#include <fresco/math.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <utility>

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
Raster<T> nearest_resized(const Raster<T>& raster, const Raster8& like, Protocol protocol)
{
    if (raster.width == like.width && raster.height == like.height)
        return raster;
    const auto pixel = is_released(protocol) ? corner_pixel : nearest;
    Raster<T> result(like.width, like.height);
    for (int y = 0; y < like.height; ++y)
        for (int x = 0; x < like.width; ++x)
            result.at(x, y) = raster.at(pixel(x, like.width, raster.width), pixel(y, like.height, raster.height));
    return result;
}

/// Marks pixels of the smallest height whose first or second choice is a level, with its share there, the first's if both.
struct Roles
{
    Raster8 first;
    Raster8 second;
    RasterF share;
};

std::vector<Roles> assigned_roles(const Raster<double>& depth, std::span<const int> heights, const LevelRules& rules)
{
    const Roles none{Raster8(depth.width, depth.height), Raster8(depth.width, depth.height), RasterF(depth.width, depth.height)};
    std::vector<Roles> roles(heights.size(), none);
    for (std::size_t i = 0; i < depth.values.size(); ++i)
    {
        if (!(depth.values[i] > 0))
            continue;
        const auto choice = level_choice(depth.values[i], heights, rules.theta_d_m);
        roles[choice.first].first.values[i] = 1;
        roles[choice.first].share.values[i] = static_cast<float>(choice.first_weight);
        if (is_released(rules.protocol) || choice.first_weight < 1)
            roles[choice.second].second.values[i] = 1;
        if (choice.second != choice.first)
            roles[choice.second].share.values[i] = static_cast<float>(1 - choice.first_weight);
    }
    return roles;
}

/// Keeps the pixels whose nine neighbors are all in the mask; outside of the picture none is.
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

/// The level of the smallest height's pixels: `all` eroded after the union of the roles, the weight per role.
LevelPixels eroded_level(const Roles& roles)
{
    Raster8 either = roles.first;
    for (std::size_t i = 0; i < either.values.size(); ++i)
        either.values[i] |= roles.second.values[i];
    LevelPixels level{eroded(either), {}, roles.share, {}};
    const Raster8 first = eroded(roles.first);
    const Raster8 second = eroded(roles.second);
    for (std::size_t i = 0; i < level.weight.values.size(); ++i)
        if ((roles.first.values[i] != 0 ? first : second).values[i] == 0)
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

void filter_by_angle(LevelPixels& level, const UvMap& map, const UvMap& smallest, const LevelRules& rules)
{
    const bool released = is_released(rules.protocol);
    RasterF angles = degrees(map.cosine);
    if (released && map.cosine.width != smallest.cosine.width)
    {
        // The angles themselves are enlarged for the filter, the cosines for the scaling.
        angles = resized(degrees(smallest.cosine), map.cosine.width, map.cosine.height);
        level.cosine = resized(smallest.cosine, map.cosine.width, map.cosine.height);
    }
    level.fine = level.all;
    for (std::size_t i = 0; i < level.fine.values.size(); ++i)
    {
        const auto angle = static_cast<double>(angles.values[i]);
        if (!(released ? angle < rules.angle_limit_deg : angle <= rules.angle_limit_deg))
            level.fine.values[i] = 0;
    }
}

/// A level that is shown as a whole.
LevelPixels whole_level(const UvMap& map, const Raster<double>& depth, Protocol protocol)
{
    LevelPixels level{map.valid, {}, RasterF(map.valid.width, map.valid.height), {}};
    if (!is_released(protocol))
    {
        std::ranges::transform(map.valid.values, level.weight.values.begin(),
                               [](auto valid) { return valid != 0 ? 1.0F : 0.0F; });
        return level;
    }
    Raster8 mask(depth.width, depth.height);
    std::ranges::transform(depth.values, mask.values.begin(), [](double d) { return static_cast<std::uint8_t>(d > 0); });
    level.all = nearest_resized(mask, map.valid, protocol);
    std::ranges::fill(level.weight.values, 1.0F);
    return level;
}

}  // namespace

LevelChoice level_choice(double depth_m, std::span<const int> heights_px, double theta_d_m)
{
    const double ideal = theta_min_px * depth_m / theta_d_m;
    std::size_t first = 0;
    for (std::size_t i = 1; i < heights_px.size(); ++i)
        if (std::abs(ideal - heights_px[i]) < std::abs(ideal - heights_px[first]))
            first = i;
    const double height = heights_px[first];
    const bool above = ideal > height;
    if (ideal == height || (above ? first + 1 == heights_px.size() : first == 0))
        return {first, first, 1};
    const std::size_t second = above ? first + 1 : first - 1;
    return {first, second, 1 - std::abs(ideal - height) / std::abs(height - heights_px[second])};
}

std::int64_t LevelPixels::count() const
{
    return std::count_if(all.values.begin(), all.values.end(), [](auto v) { return v != 0; });
}

int corner_pixel(int i, int to, int from)
{
    const float step = static_cast<float>(from) / static_cast<float>(to);
    return std::min(static_cast<int>(std::floor(static_cast<float>(i) * step)), from - 1);
}

std::vector<LevelPixels> levels_of(std::span<const UvMap> maps, const Raster<double>& depth, const LevelRules& rules)
{
    std::vector<int> heights;
    for (const auto& map : maps)
        heights.push_back(map.valid.height);
    const auto roles = rules.by_depth ? assigned_roles(depth, heights, rules) : std::vector<Roles>(maps.size());
    std::vector<LevelPixels> levels;
    for (std::size_t i = 0; i < maps.size(); ++i)
    {
        const auto& valid = maps[i].valid;
        LevelPixels level;
        if (rules.by_depth)
        {
            const LevelPixels small = eroded_level(roles[i]);
            level.all = nearest_resized(small.all, valid, rules.protocol);
            level.weight = nearest_resized(small.weight, valid, rules.protocol);
            if (!is_released(rules.protocol))
                keep_valid(level, valid);
        }
        else
            level = whole_level(maps[i], depth, rules.protocol);
        filter_by_angle(level, maps[i], maps[0], rules);
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
            factor.values[i] = pixels.all.values[i] != 0 || pixels.weight.values[i] > 0 ? 1.0F : 0.0F;
    return factor;
}

namespace
{

/// Sums over boxes of cells of `align` x `align` pixels: which of them the mask touches.
class CellCounts
{
  public:
    CellCounts(const Raster8& mask, int align)
        : sums_((mask.width + align - 1) / align + 1, (mask.height + align - 1) / align + 1)
    {
        for (int y = 0; y < mask.height; ++y)
            for (int x = 0; x < mask.width; ++x)
                if (mask.at(x, y) != 0)
                    sums_.at(x / align + 1, y / align + 1) = 1;
        for (int y = 1; y < sums_.height; ++y)
            for (int x = 1; x < sums_.width; ++x)
                sums_.at(x, y) += sums_.at(x - 1, y) + sums_.at(x, y - 1) - sums_.at(x - 1, y - 1);
    }

    PixelBox whole() const { return {0, 0, sums_.width - 1, sums_.height - 1}; }
    int count(const PixelBox& box) const
    {
        return sums_.at(box.x1, box.y1) - sums_.at(box.x0, box.y1) - sums_.at(box.x1, box.y0) + sums_.at(box.x0, box.y0);
    }
    /// The smallest box that holds what `box` holds.
    PixelBox shrunk(PixelBox box) const
    {
        while (box.x0 < box.x1 && count({box.x0, box.y0, box.x0 + 1, box.y1}) == 0)
            ++box.x0;
        while (box.x0 < box.x1 && count({box.x1 - 1, box.y0, box.x1, box.y1}) == 0)
            --box.x1;
        while (box.y0 < box.y1 && count({box.x0, box.y0, box.x1, box.y0 + 1}) == 0)
            ++box.y0;
        while (box.y0 < box.y1 && count({box.x0, box.y1 - 1, box.x1, box.y1}) == 0)
            --box.y1;
        return box;
    }

  private:
    Raster<int> sums_;  ///< Sums over the cells above and to the left.
};

class Cover
{
  public:
    Cover(const Raster8& mask, const CropRules& rules)
        : counts_(mask, rules.align), width_(mask.width), height_(mask.height), rules_(rules),
          margin_((rules.margin_px + rules.align - 1) / rules.align * rules.align)
    {
    }

    std::vector<Crop> operator()()
    {
        const PixelBox all = counts_.whole();
        if (counts_.count(all) == 0)
            return {};
        split(counts_.shrunk(all));
        std::int64_t encoded = 0;
        for (const auto& crop : crops_)
            encoded += crop.encoded.area();
        const PixelBox frame{0, 0, width_, height_};
        if (10 * encoded > 9 * frame.area())
            return {{frame, frame}};
        return std::move(crops_);
    }

  private:
    /// Box of cells to pixels, `margin` wider, inside the frame.
    PixelBox pixels(const PixelBox& cells, int margin) const
    {
        const int align = rules_.align;
        return {std::max(0, cells.x0 * align - margin), std::max(0, cells.y0 * align - margin),
                std::min(width_, cells.x1 * align + margin), std::min(height_, cells.y1 * align + margin)};
    }
    std::int64_t cost(const PixelBox& cells) const { return pixels(cells, margin_).area() + rules_.crop_px; }

    /// Cuts a box in two wherever that saves most, as long as it saves a twentieth of it.
    void split(const PixelBox& box)
    {
        std::int64_t best = cost(box) - cost(box) / 20;
        std::optional<std::pair<PixelBox, PixelBox>> halves;
        const auto consider = [&](const PixelBox& a, const PixelBox& b)
        {
            const auto first = counts_.shrunk(a);
            const auto second = counts_.shrunk(b);
            const auto sum = cost(first) + cost(second);
            if (sum >= best)
                return;
            best = sum;
            halves = std::pair(first, second);
        };
        for (int x = box.x0 + 1; x < box.x1; ++x)
            consider({box.x0, box.y0, x, box.y1}, {x, box.y0, box.x1, box.y1});
        for (int y = box.y0 + 1; y < box.y1; ++y)
            consider({box.x0, box.y0, box.x1, y}, {box.x0, y, box.x1, box.y1});
        if (!halves)
        {
            crops_.push_back({pixels(box, 0), pixels(box, margin_)});
            return;
        }
        split(halves->first);
        split(halves->second);
    }

    CellCounts counts_;
    int width_;
    int height_;
    CropRules rules_;
    int margin_;
    std::vector<Crop> crops_;
};

}  // namespace

std::vector<Crop> covering_crops(const Raster8& mask, const CropRules& rules)
{
    return Cover(mask, rules)();
}

}  // namespace fresco::optimize

#include "blur.h"

#include <fresco/images/lab.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fresco::sharpest
{
namespace
{

struct Step
{
    int x, y;
};
constexpr std::array<Step, directions_count> direction_steps{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};

/// At most 12 bits, so that the squares of a block fit in 32.
Raster<std::int16_t> gray_of(const Raster8& rgb)
{
    Raster<std::int16_t> gray(rgb.width, rgb.height);
    for (std::size_t i = 0; i < gray.values.size(); ++i)
        gray.values[i] = static_cast<std::int16_t>((fixed_luma(&rgb.values[3 * i]) + (1 << 12)) >> 13);
    return gray;
}

constexpr float levels_per_step = 4;

/// Mean change of the pixels of a block whose partner is in the picture.
float mean_change(const Raster<std::int16_t>& gray, int left, int top, Step by)
{
    const int begin = std::max(left, -by.x);
    const int end = std::min(left + block_px, gray.width - std::max(by.x, 0));
    const int bottom = std::min(top + block_px, gray.height - by.y);
    if (begin >= end || top >= bottom)
        return 0;
    std::int64_t sum = 0;
    for (int y = top; y < bottom; ++y)
    {
        const std::int16_t* from = &gray.at(begin, y);
        const std::int16_t* to = &gray.at(begin + by.x, y + by.y);
        std::int32_t row = 0;
        for (int x = 0; x < end - begin; ++x)
        {
            const std::int32_t difference = to[x] - from[x];
            row += difference * difference;
        }
        sum += row;
    }
    const float count = static_cast<float>((end - begin) * (bottom - top));
    return static_cast<float>(sum) / (count * levels_per_step * levels_per_step);
}

/// Height at which detail is measured; smaller pictures keep their size.
constexpr int measured_height_px = 480;

}  // namespace

Detail detail_of(const Raster8& rgb)
{
    const bool is_large = rgb.height > measured_height_px;
    const int width =
        is_large ? static_cast<int>(std::lround(static_cast<double>(measured_height_px) * rgb.width / rgb.height)) : rgb.width;
    const Raster<std::int16_t> gray = gray_of(is_large ? resized(rgb, width, measured_height_px) : rgb);
    Detail detail{.columns = gray.width / block_px,
                  .rows = gray.height / block_px,
                  .width = gray.width,
                  .height = gray.height,
                  .blocks = {}};
    for (int row = 0; row < detail.rows; ++row)
        for (int column = 0; column < detail.columns; ++column)
        {
            BlockDetail& block = detail.blocks.emplace_back();
            const int left = column * block_px;
            const int top = row * block_px;
            for (std::size_t d = 0; d < directions_count; ++d)
                for (std::size_t k = 0; k < lags.size(); ++k)
                    block.change[d][k] =
                        mean_change(gray, left, top, {lags[k] * direction_steps[d].x, lags[k] * direction_steps[d].y});
            std::int64_t sum = 0;
            for (int y = top; y < top + block_px; ++y)
                for (int x = left; x < left + block_px; ++x)
                    sum += gray.at(x, y);
            block.gray = static_cast<float>(sum) / (levels_per_step * block_px * block_px);
        }
    return detail;
}

namespace
{

/// How far depths of one surface may differ, which is sloped within a block and measured with errors.
double tolerance_m(double depth_m)
{
    return 0.05 + 0.05 * depth_m;
}

}  // namespace

SeenSurface::SeenSurface(const RasterF& depth, const Camera& depth_camera, const Camera& color, const Detail& blocks)
    : color_(color.intrinsics.scaled_to(blocks.width, blocks.height)), camera_from_world_(color.world_from_camera),
      columns_(blocks.columns), rows_(blocks.rows), points_(blocks.blocks.size())
{
    // About four samples a block.
    const int step = std::max(1, depth.width / std::max(1, 2 * columns_));
    for (int y = step / 2; y < depth.height; y += step)
        for (int x = step / 2; x < depth.width; x += step)
        {
            const double z = static_cast<double>(depth.at(x, y));
            if (!(z > 0))
                continue;
            const Vec3f world =
                vec_cast<float>(depth_camera.world_from_camera.translation + depth_camera.ray(x + 0.5, y + 0.5) * z);
            const Vec3d seen = camera_from_world_->point(world);
            const Vec2d pixel = pixel_of(seen);
            const auto block = block_at(pixel);
            if (!(seen.z > 0) || !block)
                continue;
            Point& point = points_[*block];
            if (point.depth_m == 0 || seen.z < static_cast<double>(point.depth_m))
                point = {world, {static_cast<float>(pixel.x), static_cast<float>(pixel.y)}, static_cast<float>(seen.z)};
        }
}

Vec2d SeenSurface::pixel_of(Vec3d in_camera) const
{
    return {color_.fx * in_camera.x / in_camera.z + color_.cx, color_.fy * in_camera.y / in_camera.z + color_.cy};
}

std::optional<std::size_t> SeenSurface::block_at(Vec2d pixel) const
{
    const double column = pixel.x / block_px;
    const double row = pixel.y / block_px;
    if (!(column >= 0 && row >= 0 && column < columns_ && row < rows_))
        return std::nullopt;
    return static_cast<std::size_t>(static_cast<int>(row) * columns_ + static_cast<int>(column));
}

std::optional<SeenSurface::Place> SeenSurface::place_of(Vec3f world) const
{
    if (points_.empty())
        return std::nullopt;
    const Vec3d seen = camera_from_world_->point(world);
    if (!(seen.z > 0))
        return std::nullopt;
    const Vec2d pixel = pixel_of(seen);
    const auto block = block_at(pixel);
    if (!block)
        return std::nullopt;
    const auto there = static_cast<double>(points_[*block].depth_m);
    if (there == 0 || std::abs(there - seen.z) > tolerance_m(seen.z))
        return std::nullopt;
    return Place{*block, {static_cast<float>(pixel.x), static_cast<float>(pixel.y)}};
}

namespace
{

/// Neighbors to either side, in recorded frames: where the camera moves fast, those next to a frame are as blurred.
constexpr std::size_t reach = 24;
constexpr std::size_t reach_without_surface = 2;
/// Smallest share of blocks that allows a judgment.
constexpr double least_share = 0.03;
/// How much longer, shorter or turned distances may be in another picture: beyond that, its pixels show other detail.
constexpr float largest_scale = 1.25F;
constexpr float least_cosine = 0.95F;
/// Detail beyond the noise.
constexpr float least_over_noise = 4;
/// Standard deviations of half a gray level and of five; it is the square of a difference.
constexpr float least_noise = 0.5F;
constexpr float most_noise = 50;
/// Neighbors that decide how sharp a frame looks beside them: the sharper quarter.
constexpr double quantile = 0.75;

/// Change of even areas at lag 1: the second percentile of each view's blocks, and the lower quartile of these, as some views
/// show no even area.
float noise_of(const std::vector<BlurView>& views)
{
    std::vector<float> per_view;
    for (const BlurView& view : views)
    {
        std::vector<float> changes;
        for (const BlockDetail& block : view.detail.blocks)
            for (const auto& along : block.change)
                changes.push_back(along[0]);
        if (changes.empty())
            continue;
        const auto low = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 50);
        std::ranges::nth_element(changes, low);
        per_view.push_back(*low);
    }
    if (per_view.empty())
        return least_noise;
    const auto quartile = per_view.begin() + static_cast<std::ptrdiff_t>(per_view.size() / 4);
    std::ranges::nth_element(per_view, quartile);
    return std::clamp(*quartile, least_noise, most_noise);
}

struct Match
{
    const BlockDetail* own;
    const BlockDetail* other;
    float scale;  ///< How many pixels of the other picture one of our own covers.
};

/// How much longer the way from one block's point to another's is in the other picture; nothing where it is not alike, or leads
/// over an edge.
std::optional<float> scale_between(const std::vector<SeenSurface::Point>& points,
                                   const std::vector<std::optional<SeenSurface::Place>>& places, std::size_t from, std::size_t to)
{
    if (!places[from] || !places[to])
        return std::nullopt;
    const Vec2f own = points[to].pixel - points[from].pixel;
    const Vec2f other = places[to]->pixel - places[from]->pixel;
    const float lengths = length(own) * length(other);
    const float scale = length(other) / std::max(length(own), 1e-3F);
    if (!(scale < largest_scale && scale > 1 / largest_scale) || dot(own, other) < least_cosine * lengths)
        return std::nullopt;
    return scale;
}

std::vector<Match> matches(const BlurView& view, const BlurView& other)
{
    std::vector<Match> result;
    if (view.surface.points().empty() || other.surface.points().empty())
    {
        if (view.detail.blocks.size() == other.detail.blocks.size())
            for (std::size_t b = 0; b < view.detail.blocks.size(); ++b)
                result.push_back({&view.detail.blocks[b], &other.detail.blocks[b], 1});
        return result;
    }
    const auto& points = view.surface.points();
    std::vector<std::optional<SeenSurface::Place>> places;
    for (const SeenSurface::Point& point : points)
        places.push_back(point.depth_m > 0 ? other.surface.place_of(point.world) : std::nullopt);
    const auto columns = static_cast<std::size_t>(view.detail.columns);
    for (std::size_t b = 0; b + columns < points.size(); ++b)
    {
        if ((b + 1) % columns == 0 || !places[b])
            continue;
        const auto across = scale_between(points, places, b, b + 1);
        const auto down = scale_between(points, places, b, b + columns);
        if (across && down)
            result.push_back({&view.detail.blocks[b], &other.detail.blocks[places[b]->block], std::sqrt(*across * *down)});
    }
    return result;
}

/// Relative brightness, squared: contrasts grow with the exposure.
float exposure(const std::vector<Match>& matched)
{
    double own = 0;
    double others = 0;
    for (const Match& match : matched)
    {
        own += static_cast<double>(match.own->gray);
        others += static_cast<double>(match.other->gray);
    }
    return own > 0 && others > 0 ? static_cast<float>((own / others) * (own / others)) : 1;
}

/// Blur along one direction, as compared with one neighbor.
struct Line
{
    double px;  ///< Length of the line that blurs the other picture as much as our own is; 0 where our own is as sharp.
    std::size_t voters;
};

/// Returns nothing where there is too little detail.
std::optional<Line> line_of(const std::vector<Match>& matched, std::size_t direction, float noise, float gain, std::size_t least)
{
    // Each block votes between -1 and 1 on whether it has more detail than the other would have, blurred that far: no edge
    // outweighs all others.
    std::array<double, lags.size()> votes{};
    std::size_t voters = 0;
    for (const Match& match : matched)
    {
        const auto& own = match.own->change[direction];
        const auto& other = match.other->change[direction];
        if (own[0] + gain * other[0] < least_over_noise * noise * (1 + gain))
            continue;
        ++voters;
        const float detail = std::max(0.0F, own[0] - noise);
        for (std::size_t k = 0; k < lags.size(); ++k)
        {
            const auto length = static_cast<float>(lags[k]);
            // A picture from farther away has more edges in a block.
            const float blurred = gain * match.scale * std::max(0.0F, other[k] - noise) / (length * length);
            if (detail + blurred > 0)
                votes[k] += static_cast<double>((detail - blurred) / (detail + blurred));
        }
    }
    if (voters < least)
        return std::nullopt;
    double steps = 1;
    if (votes[0] < 0)
    {
        std::size_t k = 1;
        while (k < lags.size() && votes[k] < 0)
            ++k;
        steps = lags.back();
        if (k < lags.size())
        {
            const double share = votes[k - 1] / (votes[k - 1] - votes[k]);
            steps = std::exp2(std::log2(lags[k - 1]) + share * std::log2(static_cast<double>(lags[k]) / lags[k - 1]));
        }
    }
    // The mean of n pixels spreads as much as a line of √(n² - 1).
    const double step_px = direction < 2 ? 1 : std::numbers::sqrt2;
    return Line{step_px * std::sqrt(steps * steps - 1), voters};
}

/// Neighbors count by how much of the surface they share.
double quantile_of(std::vector<Line>& lines)
{
    std::ranges::stable_sort(lines, {}, &Line::px);
    std::size_t all = 0;
    for (const Line& line : lines)
        all += line.voters;
    std::size_t below = 0;
    for (const Line& line : lines)
        if (below += line.voters; static_cast<double>(below) >= quantile * static_cast<double>(all))
            return line.px;
    return lines.back().px;
}

double blur_of(const std::vector<BlurView>& views, std::size_t at, float noise)
{
    const BlurView& view = views[at];
    const auto least = static_cast<std::size_t>(least_share * static_cast<double>(view.detail.blocks.size())) + 1;
    const std::size_t around = view.surface.points().empty() ? reach_without_surface : reach;
    std::array<std::vector<Line>, directions_count> lines;
    const std::size_t end = std::min(views.size(), at + around + 1);
    for (std::size_t other = at > around ? at - around : 0; other < end; ++other)
    {
        if (other == at || views[other].sequence != view.sequence)
            continue;
        const std::vector<Match> matched = matches(view, views[other]);
        if (matched.size() < least)
            continue;
        const float gain = exposure(matched);
        for (std::size_t d = 0; d < directions_count; ++d)
            if (const auto line = line_of(matched, d, noise, gain, least))
                lines[d].push_back(*line);
    }
    double most = 0;
    for (std::vector<Line>& along : lines)
        if (!along.empty())
            most = std::max(most, quantile_of(along));
    return most;
}

/// Whether a square of two by two blocks of the view shows what none of `others` shows. Less than that are the depth pictures'
/// errors.
bool shows_new_piece(const std::vector<BlurView>& views, std::size_t at, const std::vector<std::size_t>& others)
{
    const auto& points = views[at].surface.points();
    std::vector<bool> is_new;
    for (const SeenSurface::Point& point : points)
        is_new.push_back(point.depth_m > 0 &&
                         std::ranges::none_of(others, [&](std::size_t other)
                                              { return views[other].surface.place_of(point.world).has_value(); }));
    const auto columns = static_cast<std::size_t>(views[at].detail.columns);
    for (std::size_t b = 0; b + columns + 1 < is_new.size(); ++b)
        if ((b + 1) % columns != 0 && is_new[b] && is_new[b + 1] && is_new[b + columns] && is_new[b + columns + 1])
            return true;
    return false;
}

}  // namespace

std::vector<double> blur_px(const std::vector<BlurView>& views, Progress& progress)
{
    const float noise = noise_of(views);
    std::vector<double> result(views.size());
    parallel_for_each(views.size(), "comparisons", progress, [&](std::size_t i) { result[i] = blur_of(views, i, noise); });
    return result;
}

std::vector<std::size_t> needed_views(const std::vector<BlurView>& views, const std::vector<double>& blur,
                                      const std::vector<bool>& is_kept, const Progress& progress)
{
    std::vector<std::size_t> staying;
    std::vector<std::size_t> dropped;
    for (std::size_t i = 0; i < views.size(); ++i)
        (is_kept[i] ? staying : dropped).push_back(i);
    std::ranges::stable_sort(dropped, {}, [&](std::size_t i) { return blur[i]; });
    std::vector<std::size_t> needed;
    for (const std::size_t i : dropped)
    {
        progress.check_canceled();
        if (!shows_new_piece(views, i, staying))
            continue;
        needed.push_back(i);
        staying.push_back(i);
    }
    return needed;
}

}  // namespace fresco::sharpest

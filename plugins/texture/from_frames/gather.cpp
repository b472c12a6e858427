#include "gather.h"

#include <fresco/math.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace fresco::from_frames
{

PicturePyramid::PicturePyramid(const Raster8& rgb)
{
    RasterF level(rgb.width, rgb.height, 3);
    std::transform(rgb.values.begin(), rgb.values.end(), level.values.begin(),
                   [](std::uint8_t v) { return static_cast<float>(v) / 255; });
    levels_.push_back(std::move(level));
    while (levels_.back().width > 1 && levels_.back().height > 1)
        levels_.push_back(resized(levels_.back(), levels_.back().width / 2, levels_.back().height / 2));
}

PicturePyramid::Lod PicturePyramid::lod(double footprint) const
{
    const double lod = std::clamp(std::log2(std::max(footprint, 1.0)), 0.0, static_cast<double>(levels_.size() - 1));
    const auto level = static_cast<std::size_t>(lod);
    return {level, static_cast<float>(lod - static_cast<double>(level))};
}

std::array<float, 3> PicturePyramid::at(double x, double y, Lod lod) const
{
    const auto u = static_cast<float>(x / width());
    const auto v = static_cast<float>(1 - y / height());
    std::array<float, 3> color{};
    sample_bilinear(levels_[lod.level], u, v, color.data());
    if (lod.share > 0)
    {
        std::array<float, 3> coarse{};
        sample_bilinear(levels_[lod.level + 1], u, v, coarse.data());
        for (std::size_t c = 0; c < 3; ++c)
            color[c] += (coarse[c] - color[c]) * lod.share;
    }
    return color;
}

namespace
{

constexpr double step_share = 0.02;
constexpr double step_m = 0.01;
/// Texture per meter between neighbors of one chart, over the view's usual one.
constexpr double most_stretch = 5;
/// Every so many links, one enters the statistics; prime, so that no image column is preferred.
constexpr std::size_t sample_distance = 7;

/// Along one row or column: pixel i is valid and has 1 / depth `inverse(i)`.
template <class Valid, class Inverse>
bool is_step(int i, int count, const Valid& valid, const Inverse& inverse)
{
    const double here = inverse(i);
    const double next = inverse(i + 1);
    double jump = std::abs(next - here);
    if (i > 0 && valid(i - 1))
        jump = std::min(jump, std::abs(next - here - (here - inverse(i - 1))));
    if (i + 2 < count && valid(i + 2))
        jump = std::min(jump, std::abs(next - here - (inverse(i + 2) - next)));
    // A change of 1 / z by j is one of z by about z² j.
    const double nearer_m = 1 / std::max(here, next);
    return jump * nearer_m > step_share + step_m / nearer_m;
}

double squared(Vec3d v)
{
    return dot(v, v);
}

}  // namespace

PixelLinks::PixelLinks(const UvMap& map, const Camera& camera) : links_(map.valid.width, map.valid.height), valid_(map.valid)
{
    link_surfaces(map);
    link_texels(map, camera);
}

void PixelLinks::link_surfaces(const UvMap& map)
{
    const int width = valid_.width;
    const int height = valid_.height;
    std::vector<double> inverses(map.depth.values.size());
    std::ranges::transform(map.depth.values, inverses.begin(), [](float depth) { return 1 / static_cast<double>(depth); });
    const auto inverse = [&](int x, int y) { return inverses[static_cast<std::size_t>(y) * width + x]; };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (valid_.at(x, y) == 0)
                continue;
            if (x + 1 < width && valid_.at(x + 1, y) != 0 &&
                !is_step(
                    x, width, [&](int i) { return valid_.at(i, y) != 0; }, [&](int i) { return inverse(i, y); }))
                links_.at(x, y) |= surface_right;
            if (y + 1 < height && valid_.at(x, y + 1) != 0 &&
                !is_step(
                    y, height, [&](int i) { return valid_.at(x, i) != 0; }, [&](int i) { return inverse(x, i); }))
                links_.at(x, y) |= surface_down;
        }
}

void PixelLinks::link_texels(const UvMap& map, const Camera& camera)
{
    const int width = valid_.width;
    const int height = valid_.height;
    const Camera own{camera.intrinsics.scaled_to(width, height), {}};
    std::vector<Vec3d> points;
    points.reserve(map.depth.values.size());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            points.push_back(own.ray(x + 0.5, y + 0.5) * static_cast<double>(map.depth.at(x, y)));
    const auto point = [&](int x, int y) { return points[static_cast<std::size_t>(y) * width + x]; };
    // Squared texture per meter of the link to (x + dx, y + dy).
    const auto density = [&](int x, int y, int dx, int dy)
    {
        const double du = static_cast<double>(map.uv.at(x + dx, y + dy, 0)) - static_cast<double>(map.uv.at(x, y, 0));
        const double dv = static_cast<double>(map.uv.at(x + dx, y + dy, 1)) - static_cast<double>(map.uv.at(x, y, 1));
        return (du * du + dv * dv) / squared(point(x + dx, y + dy) - point(x, y));
    };
    std::vector<double> samples;
    std::size_t number = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (has(x, y, surface_right) && number++ % sample_distance == 0)
                samples.push_back(density(x, y, 1, 0));
    if (samples.empty())
        return;
    const auto quartile = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 4);
    std::nth_element(samples.begin(), quartile, samples.end());
    texture_per_m_ = std::sqrt(*quartile);
    const double most = *quartile * most_stretch * most_stretch;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (has(x, y, surface_right) && density(x, y, 1, 0) <= most)
                links_.at(x, y) |= texels_right;
            if (has(x, y, surface_down) && density(x, y, 0, 1) <= most)
                links_.at(x, y) |= texels_down;
        }
}

Raster8 PixelLinks::at_steps() const
{
    Raster8 result(valid_.width, valid_.height);
    const auto mark = [&](int x, int y)
    {
        if (valid_.at(x, y) != 0)
            result.at(x, y) = 1;
    };
    for (int y = 0; y < valid_.height; ++y)
        for (int x = 0; x < valid_.width; ++x)
        {
            if (x + 1 < valid_.width && !has(x, y, surface_right))
            {
                mark(x, y);
                mark(x + 1, y);
            }
            if (y + 1 < valid_.height && !has(x, y, surface_down))
            {
                mark(x, y);
                mark(x, y + 1);
            }
        }
    return result;
}

namespace
{

constexpr float far_away = 1e6F;
constexpr float last_resort = 1e-3F;
/// A picture is fine enough where its pixels are at most two texels wide. More resolution does not make up for a lesser angle:
/// near views would outweigh all others together where they are out of place.
constexpr double enough_pixels = 0.25;
/// Difference of measured depth and mesh that something makes which the mesh does not have, in meters and per meter of depth.
constexpr double sensor_tolerance_m = 0.1;
constexpr double sensor_share = 0.05;
/// Pixels of the camera's picture beside a depth step that do not count: as far as poses and meshes are usually off.
constexpr double edge_margin_px = 3;
/// Over this share of the height a view fades out toward the picture's border.
constexpr double border_share = 0.1;
/// Beyond the margin beside a depth step trust rises over so many margins.
constexpr float rise_margins = 2;

}  // namespace

RasterF distance_to(const Raster8& marked)
{
    const int width = marked.width;
    const int height = marked.height;
    RasterF distance(width, height, 1, far_away);
    for (std::size_t i = 0; i < marked.values.size(); ++i)
        if (marked.values[i] != 0)
            distance.values[i] = 0;
    constexpr float diagonal = std::numbers::sqrt2_v<float>;
    const auto take = [&](int x, int y, int from_x, int from_y, float step)
    {
        if (from_x >= 0 && from_x < width && from_y >= 0 && from_y < height)
            distance.at(x, y) = std::min(distance.at(x, y), distance.at(from_x, from_y) + step);
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            take(x, y, x - 1, y, 1);
            take(x, y, x - 1, y - 1, diagonal);
            take(x, y, x, y - 1, 1);
            take(x, y, x + 1, y - 1, diagonal);
        }
    for (int y = height - 1; y >= 0; --y)
        for (int x = width - 1; x >= 0; --x)
        {
            take(x, y, x + 1, y, 1);
            take(x, y, x + 1, y + 1, diagonal);
            take(x, y, x, y + 1, 1);
            take(x, y, x - 1, y + 1, diagonal);
        }
    return distance;
}

RejectedPixels rejected_pixels(const UvMap& map, const RasterF& measured)
{
    RejectedPixels rejected(measured.values.size());
    for (std::size_t i = 0; i < rejected.size(); ++i)
    {
        const auto depth = static_cast<double>(map.depth.values[i]);
        const auto seen = static_cast<double>(measured.values[i]);
        rejected[i] = map.valid.values[i] != 0 && seen > 0 && std::abs(seen - depth) > sensor_tolerance_m + sensor_share * depth;
    }
    return rejected;
}

ViewWeights view_weights(const UvMap& map, const PixelLinks& links, const Camera& camera, const RejectedPixels& rejected,
                         int size_px)
{
    const int width = map.valid.width;
    const int height = map.valid.height;
    ViewWeights result;
    result.trust = RasterF(width, height);
    result.weight = RasterF(width, height);

    Raster8 doubtful = links.at_steps();
    for (std::size_t i = 0; i < rejected.size(); ++i)
        if (rejected[i])
            doubtful.values[i] = 1;
    const RasterF distance = distance_to(doubtful);

    const auto margin = static_cast<float>(edge_margin_px * height / camera.intrinsics.height);
    const auto border = static_cast<float>(border_share * height);
    const double texels_per_m2 = std::pow(links.texture_per_m() * size_px, 2);
    const double focal_squared = camera.intrinsics.fx * camera.intrinsics.fy;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (map.valid.at(x, y) == 0)
                continue;
            const bool is_rejected = !rejected.empty() && rejected[map.valid.index(x, y)];
            float trust = std::clamp((distance.at(x, y) - margin) / (rise_margins * margin), 0.0F, 1.0F);
            result.edge_pixels += distance.at(x, y) <= margin && !is_rejected;
            const int inside = std::min(std::min(x, width - 1 - x), std::min(y, height - 1 - y));
            trust *= std::min(1.0F, (static_cast<float>(inside) + 0.5F) / border);
            if (is_rejected)
                continue;
            const auto depth = static_cast<double>(map.depth.at(x, y));
            const auto cosine = static_cast<double>(map.cosine.at(x, y));
            if (!(depth > 0) || !(cosine > 0))
                continue;
            const double pixels_per_texel = focal_squared * cosine / (depth * depth) / texels_per_m2;
            result.trust.at(x, y) = trust;
            result.weight.at(x, y) =
                static_cast<float>(cosine * std::min(1.0, pixels_per_texel / enough_pixels)) * std::max(trust, last_resort);
        }
    return result;
}

namespace
{

constexpr double beside_pixels = 1e-2;
/// So that no texel center falls between two triangles.
constexpr double rounding = 1e-9;

/// A pixel center of the map in the texture.
struct Corner
{
    double x = 0;  ///< In texels, whole numbers are texel centers, rightwards …
    double y = 0;  ///< … and downwards.
    double column = 0;
    double row = 0;
    double weight = 0;
};

double cross(const Corner& a, const Corner& b, const Corner& c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

class Gatherer
{
  public:
    Gatherer(const UvMap& map, const PixelLinks& links, const RasterF& weight, const PicturePyramid& picture,
             const GatherTarget& target)
        : map_(map), links_(links), weight_(weight), picture_(picture), target_(target),
          scale_x_(static_cast<double>(picture.width()) / map.valid.width),
          scale_y_(static_cast<double>(picture.height()) / map.valid.height), squares_(map.valid.width, map.valid.height)
    {
        blocks_.resize(static_cast<std::size_t>((target.size_px + target.rows_per_block - 1) / target.rows_per_block));
    }

    SampleBlocks gathered()
    {
        for (int y = 0; y + 1 < weight_.height; ++y)
            for (int x = 0; x + 1 < weight_.width; ++x)
                draw_square(x, y);
        if (!target_.between_only)
            for (int y = 0; y < weight_.height; ++y)
                for (int x = 0; x < weight_.width; ++x)
                    if (squares_.at(x, y) < 4 && weight_.at(x, y) > 0)
                        splat(x, y);
        for (std::size_t block = 0; block < blocks_.size(); ++block)
            keep_heaviest(block);
        return std::move(blocks_);
    }

  private:
    Corner corner(int x, int y) const
    {
        return {static_cast<double>(map_.uv.at(x, y, 0)) * target_.size_px - 0.5,
                (1 - static_cast<double>(map_.uv.at(x, y, 1))) * target_.size_px - 0.5, x + 0.5, y + 0.5,
                static_cast<double>(weight_.at(x, y))};
    }

    bool linked(int x, int y, PixelLinks::Link link) const
    {
        const bool right = link == PixelLinks::texels_right;
        return links_.has(x, y, link) && weight_.at(x, y) > 0 && weight_.at(right ? x + 1 : x, right ? y : y + 1) > 0;
    }

    void draw_square(int x, int y)
    {
        const bool top = linked(x, y, PixelLinks::texels_right);
        const bool bottom = linked(x, y + 1, PixelLinks::texels_right);
        const bool left = linked(x, y, PixelLinks::texels_down);
        const bool right = linked(x + 1, y, PixelLinks::texels_down);
        const int sides = int{top} + int{bottom} + int{left} + int{right};
        if (sides == 4)
        {
            draw(corner(x, y), corner(x + 1, y), corner(x, y + 1));
            draw(corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1));
            for (int dy = 0; dy < 2; ++dy)
                for (int dx = 0; dx < 2; ++dx)
                    ++squares_.at(x + dx, y + dy);
        }
        else if (sides == 2 && top != bottom && left != right)  // Three corners, joined at the one where these sides meet.
        {
            const int column = left ? x : x + 1;
            const int row = top ? y : y + 1;
            draw(corner(column, row), corner(2 * x + 1 - column, row), corner(column, 2 * y + 1 - row));
        }
    }

    /// Three corners of a square of neighboring pixel centers.
    void draw(const Corner& a, const Corner& b, const Corner& c)
    {
        const double area = cross(a, b, c);
        if (area == 0)
            return;
        const double last = target_.size_px - 1;
        const auto first_row = static_cast<int>(std::ceil(std::max(0.0, std::min({a.y, b.y, c.y}))));
        const auto last_row = static_cast<int>(std::floor(std::min(last, std::max({a.y, b.y, c.y}))));
        const auto first_column = static_cast<int>(std::ceil(std::max(0.0, std::min({a.x, b.x, c.x}))));
        const auto last_column = static_cast<int>(std::floor(std::min(last, std::max({a.x, b.x, c.x}))));
        // The square is one pixel of the map large.
        const auto lod = picture_.lod(std::sqrt(scale_x_ * scale_y_ / std::abs(area)));
        for (int row = first_row; row <= last_row; ++row)
            for (int column = first_column; column <= last_column; ++column)
            {
                const Corner here{static_cast<double>(column), static_cast<double>(row), 0, 0, 0};
                const double of_a = cross(b, c, here) / area;
                const double of_b = cross(c, a, here) / area;
                const double of_c = 1 - of_a - of_b;
                if (of_a < -rounding || of_b < -rounding || of_c < -rounding)
                    continue;
                const double x = of_a * a.column + of_b * b.column + of_c * c.column;
                const double y = of_a * a.row + of_b * b.row + of_c * c.row;
                add(column, row, of_a * a.weight + of_b * b.weight + of_c * c.weight,
                    picture_.at(x * scale_x_, y * scale_y_, lod), x, y);
            }
    }

    void splat(int x, int y)
    {
        const Corner pixel = corner(x, y);
        const int last = target_.size_px - 1;
        const auto left = static_cast<int>(std::floor(pixel.x));
        const auto top = static_cast<int>(std::floor(pixel.y));
        const auto rgb = picture_.at(pixel.column * scale_x_, pixel.row * scale_y_, picture_.lod(std::sqrt(scale_x_ * scale_y_)));
        for (int row = std::max(0, top); row <= std::min(last, top + 1); ++row)
            for (int column = std::max(0, left); column <= std::min(last, left + 1); ++column)
            {
                const double share = (1 - std::abs(pixel.x - column)) * (1 - std::abs(pixel.y - row));
                if (share > 0)
                    add(column, row, beside_pixels * pixel.weight * share, rgb, pixel.column, pixel.row);
            }
    }

    /// Leaves one sample of each texel.
    void keep_heaviest(std::size_t block)
    {
        constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
        const std::size_t texels = static_cast<std::size_t>(target_.rows_per_block) * static_cast<std::size_t>(target_.size_px);
        std::vector<std::uint32_t> places(texels, none);
        auto& samples = blocks_[block];
        std::uint32_t kept = 0;
        for (const TexelSample& sample : samples)
        {
            std::uint32_t& place = places[sample.texel - block * texels];
            if (place == none)
                samples[place = kept++] = sample;
            else if (sample.weight > samples[place].weight)
                samples[place] = sample;
        }
        samples.resize(kept);
    }

    void add(int column, int row, double weight, const std::array<float, 3>& rgb, double x, double y)
    {
        const auto sample_weight = static_cast<float>(weight);
        if (sample_weight > 0)
            blocks_[static_cast<std::size_t>(row / target_.rows_per_block)].push_back(
                {static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(target_.size_px) +
                     static_cast<std::uint32_t>(column),
                 sample_weight,
                 rgb,
                 {static_cast<float>(x / map_.valid.width), static_cast<float>(y / map_.valid.height)}});
    }

    const UvMap& map_;
    const PixelLinks& links_;
    const RasterF& weight_;
    const PicturePyramid& picture_;
    GatherTarget target_;
    double scale_x_;  ///< Pixels of the picture per pixel of the map.
    double scale_y_;
    Raster8 squares_;  ///< Whole squares drawn around each pixel.
    SampleBlocks blocks_;
};

}  // namespace

SampleBlocks gather(const UvMap& map, const PixelLinks& links, const RasterF& weight, const PicturePyramid& picture,
                    const GatherTarget& target)
{
    return Gatherer(map, links, weight, picture, target).gathered();
}

}  // namespace fresco::from_frames

#include "gather.h"

#include <fresco/math.h>
#include <fresco/numerics/wide_vectors.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace fresco::from_frames
{

namespace
{

RasterF halved(const RasterF& level)
{
    if (level.width % 2 != 0 || level.height % 2 != 0)
        return resized(level, level.width / 2, level.height / 2);
    RasterF half(level.width / 2, level.height / 2, 4);
    for (int y = 0; y < half.height; ++y)
        for (int x = 0; x < half.width; ++x)
        {
            Four sum{};
            for (const int row : {2 * y, 2 * y + 1})
                for (const int column : {2 * x, 2 * x + 1})
                {
                    Four pixel;
                    std::memcpy(&pixel, &level.at(column, row), sizeof pixel);
                    sum += pixel;
                }
            sum *= 0.25F;
            std::memcpy(&half.at(x, y), &sum, sizeof sum);
        }
    return half;
}

}  // namespace

PicturePyramid::PicturePyramid(const Raster8& rgb)
{
    RasterF level(rgb.width, rgb.height, 4);
    for (std::size_t i = 0; i < rgb.values.size() / 3; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            level.values[4 * i + c] = static_cast<float>(rgb.values[3 * i + c]) / 255;
    levels_.push_back(std::move(level));
    while (levels_.back().width > 1 && levels_.back().height > 1)
        levels_.push_back(halved(levels_.back()));
}

PicturePyramid::Lod PicturePyramid::lod(double footprint) const
{
    const double lod = std::clamp(std::log2(std::max(footprint, 1.0)), 0.0, static_cast<double>(levels_.size() - 1));
    const auto level = static_cast<std::size_t>(lod);
    return {level, static_cast<float>(lod - static_cast<double>(level))};
}

std::array<float, 3> PicturePyramid::at(const std::array<float, 2>& place, Lod lod) const
{
    Four color = four_between(levels_[lod.level], place[0], place[1]);
    if (lod.share > 0)
        color += (four_between(levels_[lod.level + 1], place[0], place[1]) - color) * lod.share;
    return {color[0], color[1], color[2]};
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
    const Intrinsics own = camera.intrinsics.scaled_to(width, height);
    std::vector<Vec3d> points(map.depth.values.size());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const auto depth = static_cast<double>(map.depth.at(x, y));
            points[map.depth.index(x, y)] = {(x + 0.5 - own.cx) / own.fx * depth, (y + 0.5 - own.cy) / own.fy * depth, depth};
        }
    const auto point = [&](int x, int y) { return points[map.depth.index(x, y)]; };
    // Squared length of the link to (x + dx, y + dy) in the texture, and in the world.
    const auto in_texture = [&](int x, int y, int dx, int dy)
    {
        const double du = static_cast<double>(map.uv.at(x + dx, y + dy, 0)) - static_cast<double>(map.uv.at(x, y, 0));
        const double dv = static_cast<double>(map.uv.at(x + dx, y + dy, 1)) - static_cast<double>(map.uv.at(x, y, 1));
        return du * du + dv * dv;
    };
    const auto in_world = [&](int x, int y, int dx, int dy) { return squared(point(x + dx, y + dy) - point(x, y)); };
    std::vector<double> samples;
    std::size_t number = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (has(x, y, surface_right) && number++ % sample_distance == 0)
                samples.push_back(in_texture(x, y, 1, 0) / in_world(x, y, 1, 0));
    if (samples.empty())
        return;
    const auto quartile = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 4);
    std::nth_element(samples.begin(), quartile, samples.end());
    texture_per_m_ = std::sqrt(*quartile);
    const double most = *quartile * most_stretch * most_stretch;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (has(x, y, surface_right) && in_texture(x, y, 1, 0) <= most * in_world(x, y, 1, 0))
                links_.at(x, y) |= texels_right;
            if (has(x, y, surface_down) && in_texture(x, y, 0, 1) <= most * in_world(x, y, 0, 1))
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
    // With a border of its own, where everything is far away.
    RasterF padded(width + 2, height + 2, 1, far_away);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (marked.at(x, y) != 0)
                padded.at(x + 1, y + 1) = 0;
    constexpr float diagonal = std::numbers::sqrt2_v<float>;
    const auto pass = [&](int step)  // Through the rows and the columns: 1 forward, -1 backward.
    {
        for (int row = 1; row <= height; ++row)
        {
            const int y = step > 0 ? row : height + 1 - row;
            float* here = &padded.at(step > 0 ? 1 : width, y);
            const float* before = &padded.at(step > 0 ? 1 : width, y - step);
            for (int i = 0; i < width; ++i, here += step, before += step)
                *here = std::min(std::min(*here, here[-step] + 1),
                                 std::min(before[0] + 1, std::min(before[-1], before[1]) + diagonal));
        }
    };
    pass(1);
    pass(-1);
    RasterF distance(width, height);
    for (int y = 0; y < height; ++y)
        std::copy_n(&padded.at(1, y + 1), width, &distance.at(0, y));
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
    double x = 0;       ///< In texels, whole numbers are texel centers, rightwards …
    double y = 0;       ///< … and downwards.
    double across = 0;  ///< In the picture, in [0,1], rightward …
    double down = 0;    ///< … and downward.
    double weight = 0;
};

struct Linked
{
    Corner corner;
    bool right;
    bool down;
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
        : map_(map), links_(links), weight_(weight), picture_(picture), target_(target), share_x_(1.0 / map.valid.width),
          share_y_(1.0 / map.valid.height), pixels_(picture.width() * share_x_ * picture.height() * share_y_),
          squares_(map.valid.width, map.valid.height)
    {
        blocks_.resize(static_cast<std::size_t>((target.size_px + target.rows_per_block - 1) / target.rows_per_block));
    }

    FRESCO_WIDE_VECTORS SampleBlocks gathered()
    {
        load_row(0);
        for (int y = 0; y + 1 < weight_.height; ++y)
        {
            std::swap(upper_, lower_);
            load_row(y + 1);
            for (int x = 0; x + 1 < weight_.width; ++x)
                draw_square(x, y);
        }
        if (!target_.between_only)
            for (int y = 0; y < weight_.height; ++y)
                for (int x = 0; x < weight_.width; ++x)
                    if (squares_.at(x, y) < 4 && weight_.at(x, y) > 0)
                        splat(x, y);
        std::vector<std::uint32_t> places(texels_per_block(), none);
        for (std::size_t block = 0; block < blocks_.size(); ++block)
        {
            keep_heaviest(block, places);
            for (const TexelSample& sample : blocks_[block])
                places[sample.texel - block * texels_per_block()] = none;
        }
        return std::move(blocks_);
    }

  private:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    std::size_t texels_per_block() const
    {
        return static_cast<std::size_t>(target_.rows_per_block) * static_cast<std::size_t>(target_.size_px);
    }

    Corner corner(int x, int y) const
    {
        return {static_cast<double>(map_.uv.at(x, y, 0)) * target_.size_px - 0.5,
                (1 - static_cast<double>(map_.uv.at(x, y, 1))) * target_.size_px - 0.5, (x + 0.5) * share_x_,
                (y + 0.5) * share_y_, static_cast<double>(weight_.at(x, y))};
    }

    bool linked(int x, int y, PixelLinks::Link link) const
    {
        const bool right = link == PixelLinks::texels_right;
        return links_.has(x, y, link) && weight_.at(x, y) > 0 && weight_.at(right ? x + 1 : x, right ? y : y + 1) > 0;
    }

    void load_row(int y)
    {
        lower_.resize(static_cast<std::size_t>(weight_.width));
        for (int x = 0; x < weight_.width; ++x)
            lower_[static_cast<std::size_t>(x)] = {corner(x, y), linked(x, y, PixelLinks::texels_right),
                                                   linked(x, y, PixelLinks::texels_down)};
    }

    void draw_square(int x, int y)
    {
        const auto column = static_cast<std::size_t>(x);
        const std::array<const Linked*, 4> corners{&upper_[column], &upper_[column + 1], &lower_[column], &lower_[column + 1]};
        const bool top = corners[0]->right;
        const bool bottom = corners[2]->right;
        const bool left = corners[0]->down;
        const bool right = corners[1]->down;
        const int sides = int{top} + int{bottom} + int{left} + int{right};
        if (sides == 4)
        {
            draw(corners[0]->corner, corners[1]->corner, corners[2]->corner);
            draw(corners[1]->corner, corners[3]->corner, corners[2]->corner);
            for (int dy = 0; dy < 2; ++dy)
                for (int dx = 0; dx < 2; ++dx)
                    ++squares_.at(x + dx, y + dy);
        }
        else if (sides == 2 && top != bottom && left != right)  // Three corners, joined at the one where these sides meet.
        {
            const std::size_t joint = (left ? 0U : 1U) + (top ? 0U : 2U);
            draw(corners[joint]->corner, corners[joint ^ 1U]->corner, corners[joint ^ 2U]->corner);
        }
    }

    /// Three corners of a square of neighboring pixel centers.
    void draw(const Corner& a, const Corner& b, const Corner& c)
    {
        const double last = target_.size_px - 1;
        const double right = std::min(last, std::max(std::max(a.x, b.x), c.x));
        const double bottom = std::min(last, std::max(std::max(a.y, b.y), c.y));
        const double area = cross(a, b, c);
        if (area == 0 || right < 0 || bottom < 0)
            return;
        const auto rounded_up = [](double at) { return static_cast<int>(at) + int{static_cast<int>(at) < at}; };
        const int first_column = rounded_up(std::max(0.0, std::min(std::min(a.x, b.x), c.x)));
        const int first_row = rounded_up(std::max(0.0, std::min(std::min(a.y, b.y), c.y)));
        const auto last_column = static_cast<int>(right);
        const auto last_row = static_cast<int>(bottom);
        if (first_column > last_column || first_row > last_row)
            return;
        const double share = 1 / area;
        std::optional<PicturePyramid::Lod> lod;
        for (int row = first_row; row <= last_row; ++row)
            for (int column = first_column; column <= last_column; ++column)
            {
                const Corner here{static_cast<double>(column), static_cast<double>(row), 0, 0, 0};
                const double of_a = cross(b, c, here) * share;
                const double of_b = cross(c, a, here) * share;
                const double of_c = 1 - of_a - of_b;
                if (of_a < -rounding || of_b < -rounding || of_c < -rounding)
                    continue;
                if (!lod)  // The square is one pixel of the map large.
                    lod = picture_.lod(std::sqrt(pixels_ / std::abs(area)));
                add(column, row, of_a * a.weight + of_b * b.weight + of_c * c.weight, *lod,
                    of_a * a.across + of_b * b.across + of_c * c.across, of_a * a.down + of_b * b.down + of_c * c.down);
            }
    }

    void splat(int x, int y)
    {
        const Corner pixel = corner(x, y);
        const int last = target_.size_px - 1;
        const auto left = static_cast<int>(std::floor(pixel.x));
        const auto top = static_cast<int>(std::floor(pixel.y));
        const auto lod = picture_.lod(std::sqrt(pixels_));
        for (int row = std::max(0, top); row <= std::min(last, top + 1); ++row)
            for (int column = std::max(0, left); column <= std::min(last, left + 1); ++column)
            {
                const double share = (1 - std::abs(pixel.x - column)) * (1 - std::abs(pixel.y - row));
                if (share > 0)
                    add(column, row, beside_pixels * pixel.weight * share, lod, pixel.across, pixel.down);
            }
    }

    /// Leaves one sample of each texel. `places`: none, per texel of a block.
    void keep_heaviest(std::size_t block, std::vector<std::uint32_t>& places)
    {
        auto& samples = blocks_[block];
        std::uint32_t kept = 0;
        for (const TexelSample& sample : samples)
        {
            std::uint32_t& place = places[sample.texel - block * texels_per_block()];
            if (place == none)
                samples[place = kept++] = sample;
            else if (sample.weight > samples[place].weight)
                samples[place] = sample;
        }
        samples.resize(kept);
    }

    void add(int column, int row, double weight, PicturePyramid::Lod lod, double across, double down)
    {
        const auto sample_weight = static_cast<float>(weight);
        const std::array<float, 2> place{static_cast<float>(across), static_cast<float>(down)};
        if (sample_weight > 0)
            blocks_[static_cast<std::size_t>(row / target_.rows_per_block)].push_back(
                {static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(target_.size_px) +
                     static_cast<std::uint32_t>(column),
                 sample_weight, picture_.at(place, lod), place});
    }

    const UvMap& map_;
    const PixelLinks& links_;
    const RasterF& weight_;
    const PicturePyramid& picture_;
    GatherTarget target_;
    double share_x_;  ///< Width of the map's pixels as a share of the picture.
    double share_y_;
    double pixels_;                      ///< Pixels of the picture per pixel of the map.
    Raster8 squares_;                    ///< Whole squares drawn around each pixel.
    std::vector<Linked> upper_, lower_;  ///< Two rows of pixels.
    SampleBlocks blocks_;
};

}  // namespace

SampleBlocks gather(const UvMap& map, const PixelLinks& links, const RasterF& weight, const PicturePyramid& picture,
                    const GatherTarget& target)
{
    return Gatherer(map, links, weight, picture, target).gathered();
}

}  // namespace fresco::from_frames

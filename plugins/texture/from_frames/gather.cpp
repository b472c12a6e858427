#include "gather.h"

#include <fresco/math.h>
#include <fresco/numerics/wide_vectors.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <utility>

namespace fresco::from_frames
{

using namespace numerics::wide_vectors;

namespace
{

Raster8 halved(const Raster8& level)
{
    if (level.width % 2 != 0 || level.height % 2 != 0)
        return resized(level, level.width / 2, level.height / 2);
    Raster8 half(level.width / 2, level.height / 2, 4);
    for (int y = 0; y < half.height; ++y)
    {
        const std::uint8_t* upper = &level.at(0, 2 * y);
        const std::uint8_t* lower = &level.at(0, 2 * y + 1);
        std::uint8_t* average = &half.at(0, y);
        for (int x = 0; x < half.width; ++x, upper += 8, lower += 8)
            for (int c = 0; c < 4; ++c)
                *average++ = static_cast<std::uint8_t>((upper[c] + upper[c + 4] + lower[c] + lower[c + 4] + 2) / 4);
    }
    return half;
}

}  // namespace

PicturePyramid::PicturePyramid(const Raster8& rgb)
{
    Raster8 level(rgb.width, rgb.height, 4);
    for (std::size_t i = 0; i < rgb.values.size() / 3; ++i)
        std::copy_n(&rgb.values[3 * i], 3, &level.values[4 * i]);
    levels_.push_back(std::move(level));
    while (levels_.back().width > 1 && levels_.back().height > 1)
        levels_.push_back(halved(levels_.back()));
}

namespace
{

constexpr float step_share = 0.02F;
constexpr float step_m = 0.01F;
/// Texture per meter between neighbors of one chart, over the view's usual one.
constexpr float most_stretch = 5;
/// Every so many links, one enters the statistics; prime, so that no image column is preferred.
constexpr std::size_t sample_distance = 7;

/// Whether there is a step after pixel `i` of `count` in a row or column, whose pixels are `next` apart. `inverse`: 1 / depth at
/// it, 0: not valid.
bool is_step(int i, int count, const float* inverse, std::ptrdiff_t next)
{
    const float here = inverse[0];
    const float there = inverse[next];
    float jump = std::abs(there - here);
    if (i > 0 && inverse[-next] > 0)
        jump = std::min(jump, std::abs(there - here - (here - inverse[-next])));
    if (i + 2 < count && inverse[2 * next] > 0)
        jump = std::min(jump, std::abs(there - here - (inverse[2 * next] - there)));
    // A change of 1 / z by j is one of z by about z² j.
    const float nearer = std::max(here, there);
    return jump > nearer * (step_share + step_m * nearer);
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
    RasterF inverse(width, height);
    for (std::size_t i = 0; i < inverse.values.size(); ++i)
        inverse.values[i] = valid_.values[i] != 0 ? 1 / map.depth.values[i] : 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const float* const here = &inverse.at(x, y);
            if (*here == 0)
                continue;
            if (x + 1 < width && here[1] > 0 && !is_step(x, width, here, 1))
                links_.at(x, y) |= surface_right;
            if (y + 1 < height && here[width] > 0 && !is_step(y, height, here, width))
                links_.at(x, y) |= surface_down;
        }
}

void PixelLinks::link_texels(const UvMap& map, const Camera& camera)
{
    const int width = valid_.width;
    const int height = valid_.height;
    const Intrinsics own = camera.intrinsics.scaled_to(width, height);
    std::vector<float> across(static_cast<std::size_t>(width));
    for (int x = 0; x < width; ++x)
        across[static_cast<std::size_t>(x)] = static_cast<float>((x + 0.5 - own.cx) / own.fx);
    // Squared length in the texture over that in the world.
    const auto stretch = [&](int x, int y, int dx, int dy, float down, float next_down)
    {
        const float* const uv = &map.uv.at(x, y);
        const float* const next_uv = &map.uv.at(x + dx, y + dy);
        const float depth = map.depth.at(x, y);
        const float next_depth = map.depth.at(x + dx, y + dy);
        const float wide = across[static_cast<std::size_t>(x) + static_cast<std::size_t>(dx)] * next_depth -
                           across[static_cast<std::size_t>(x)] * depth;
        const float high = next_down * next_depth - down * depth;
        const float deep = next_depth - depth;
        return ((next_uv[0] - uv[0]) * (next_uv[0] - uv[0]) + (next_uv[1] - uv[1]) * (next_uv[1] - uv[1])) /
               (wide * wide + high * high + deep * deep);
    };
    RasterF rightward(width, height);
    RasterF downward(width, height);
    std::vector<float> samples;
    std::size_t number = 0;
    for (int y = 0; y < height; ++y)
    {
        const auto down = static_cast<float>((y + 0.5 - own.cy) / own.fy);
        const auto next_down = static_cast<float>((y + 1.5 - own.cy) / own.fy);
        for (int x = 0; x < width; ++x)
        {
            if (has(x, y, surface_right))
            {
                rightward.at(x, y) = stretch(x, y, 1, 0, down, down);
                if (number++ % sample_distance == 0)
                    samples.push_back(rightward.at(x, y));
            }
            if (has(x, y, surface_down))
                downward.at(x, y) = stretch(x, y, 0, 1, down, next_down);
        }
    }
    if (samples.empty())
        return;
    const auto quartile = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 4);
    std::nth_element(samples.begin(), quartile, samples.end());
    texture_per_m_ = std::sqrt(static_cast<double>(*quartile));
    const float most = *quartile * most_stretch * most_stretch;
    for (std::size_t i = 0; i < links_.values.size(); ++i)
    {
        std::uint8_t& links = links_.values[i];
        if ((links & surface_right) != 0 && rightward.values[i] <= most)
            links |= texels_right;
        if ((links & surface_down) != 0 && downward.values[i] <= most)
            links |= texels_down;
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
constexpr float enough_pixels = 0.25F;
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
    // This is for a surface one meter away, seen at a right angle.
    const auto pixels_per_texel =
        static_cast<float>(camera.intrinsics.fx * camera.intrinsics.fy / std::pow(links.texture_per_m() * size_px, 2));
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
            const float depth = map.depth.at(x, y);
            const float cosine = map.cosine.at(x, y);
            if (!(depth > 0) || !(cosine > 0))
                continue;
            result.trust.at(x, y) = trust;
            result.weight.at(x, y) = cosine * std::min(1.0F, pixels_per_texel * cosine / (depth * depth) / enough_pixels) *
                                     std::max(trust, last_resort);
        }
    return result;
}

namespace
{

constexpr float beside_pixels = 1e-2F;
/// So that no texel center falls between two triangles.
constexpr float rounding = 1e-5F;

/// A pixel center of the map in the texture.
struct Pixel
{
    float x = 0;  ///< In texels, whole numbers are texel centers, rightwards …
    float y = 0;  ///< … and downwards.
    float weight = 0;
    bool right = false;  ///< Linked to the next pixel in its row.
    bool down = false;   ///< Linked to the next pixel in its column.
};

/// Half squares of neighboring pixel centers, one a lane. Their corners are the pixel at the right angle, its neighbor in the
/// row, and its neighbor in the column.
struct Triangles
{
    std::array<Floats, 3> x{}, y{}, weight{};
    Floats column{}, row{};          ///< The first corner in the map …
    Floats rightward{}, downward{};  ///< … and the way from there to the other ones: 1 or -1.
};

float largest(const Floats& values)
{
    float most = values[0];
    for (std::size_t lane = 1; lane < lanes; ++lane)
        most = std::max(most, values[lane]);
    return most;
}

/// Rounds numbers of 0 or more up to whole ones.
void round_up(Floats& values)
{
    const Floats whole = __builtin_convertvector(__builtin_convertvector(values, Ints), Floats);
    values = whole < values ? whole + 1 : whole;
}

class Gatherer
{
  public:
    Gatherer(const UvMap& map, const PixelLinks& links, const RasterF& weight, const GatherTarget& target)
        : map_(map), links_(links), weight_(weight), target_(target), share_x_(1 / static_cast<float>(map.valid.width)),
          share_y_(1 / static_cast<float>(map.valid.height)), whole_(map.valid.width + 1, map.valid.height + 1), drawn_(lanes),
          texels_per_block_(static_cast<std::uint32_t>(target.rows_per_block) * static_cast<std::uint32_t>(target.size_px)),
          blocks_(static_cast<std::size_t>((target.size_px + target.rows_per_block - 1) / target.rows_per_block))
    {
    }

    FRESCO_WIDE_VECTORS void gather(const SampleUser& use)
    {
        load_row(0);
        for (int y = 0; y + 1 < weight_.height; ++y)
        {
            std::swap(upper_, lower_);
            load_row(y + 1);
            for (int x = 0; x + 1 < weight_.width; ++x)
                draw_square(x, y);
            sort_into_blocks();
        }
        draw();  // The lanes that are not new were drawn before, and equal samples count once.
        if (!target_.between_only)
            for (int y = 0; y < weight_.height; ++y)
                for (int x = 0; x < weight_.width; ++x)
                    if ((whole_.at(x, y) & whole_.at(x + 1, y) & whole_.at(x, y + 1) & whole_.at(x + 1, y + 1)) == 0 &&
                        weight_.at(x, y) > 0)
                        splat(x, y);
        sort_into_blocks();
        std::vector<std::uint32_t> places(texels_per_block_, none);
        for (std::size_t block = 0; block < blocks_.size(); ++block)
        {
            keep_heaviest(block, places);
            for (const DrawnSample& sample : blocks_[block])
                places[sample.texel - block * texels_per_block_] = none;
            use(block, blocks_[block]);
        }
    }

  private:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    Pixel pixel(int x, int y) const
    {
        const auto size = static_cast<float>(target_.size_px);
        const float weight = weight_.at(x, y);
        return {map_.uv.at(x, y, 0) * size - 0.5F, (1 - map_.uv.at(x, y, 1)) * size - 0.5F, weight,
                weight > 0 && links_.has(x, y, PixelLinks::texels_right) && weight_.at(x + 1, y) > 0,
                weight > 0 && links_.has(x, y, PixelLinks::texels_down) && weight_.at(x, y + 1) > 0};
    }

    void load_row(int y)
    {
        lower_.resize(static_cast<std::size_t>(weight_.width));
        for (int x = 0; x < weight_.width; ++x)
            lower_[static_cast<std::size_t>(x)] = pixel(x, y);
    }

    void draw_square(int x, int y)
    {
        const auto column = static_cast<std::size_t>(x);
        const std::array<const Pixel*, 4> corners{&upper_[column], &upper_[column + 1], &lower_[column], &lower_[column + 1]};
        const bool top = corners[0]->right;
        const bool bottom = corners[2]->right;
        const bool left = corners[0]->down;
        const bool right = corners[1]->down;
        const auto draw_half = [&](std::size_t joint)
        {
            const std::array<const Pixel*, 3> half{corners[joint], corners[joint ^ 1U], corners[joint ^ 2U]};
            for (std::size_t i = 0; i < 3; ++i)
            {
                triangles_.x[i][lane_] = half[i]->x;
                triangles_.y[i][lane_] = half[i]->y;
                triangles_.weight[i][lane_] = half[i]->weight;
            }
            const bool is_right = (joint & 1U) != 0;
            const bool is_lower = (joint & 2U) != 0;
            triangles_.column[lane_] = static_cast<float>(x + int{is_right});
            triangles_.row[lane_] = static_cast<float>(y + int{is_lower});
            triangles_.rightward[lane_] = is_right ? -1.0F : 1.0F;
            triangles_.downward[lane_] = is_lower ? -1.0F : 1.0F;
            lane_ = (lane_ + 1) % lanes;
            if (lane_ == 0)
                draw();
        };
        const int sides = int{top} + int{bottom} + int{left} + int{right};
        if (sides == 4)
        {
            draw_half(0);
            draw_half(3);
            whole_.at(x + 1, y + 1) = 1;
        }
        else if (sides == 2 && top != bottom && left != right)  // Three corners, joined at the one where these sides meet.
            draw_half((left ? 0U : 1U) + (top ? 0U : 2U));
    }

    /// All lanes at once: texel by texel of their bounding boxes.
    void draw()
    {
        const auto& [x, y, weight, column, row, rightward, downward] = triangles_;
        const Floats beside_x = x[1] - x[0], beside_y = y[1] - y[0];
        const Floats below_x = x[2] - x[0], below_y = y[2] - y[0];
        const Floats area = beside_x * below_y - beside_y * below_x;
        const Floats share = 1 / area;  // Without an area, no comparison below holds.
        const Floats covered = (area < 0 ? -share : share) * (share_x_ * share_y_);
        Floats left = x[0], right = x[0], top = y[0], bottom = y[0];
        for (std::size_t i = 1; i < 3; ++i)
        {
            left = x[i] < left ? x[i] : left;
            right = x[i] > right ? x[i] : right;
            top = y[i] < top ? y[i] : top;
            bottom = y[i] > bottom ? y[i] : bottom;
        }
        const auto last = static_cast<float>(target_.size_px - 1);
        left = left > 0 ? left : Floats{};
        top = top > 0 ? top : Floats{};
        round_up(left);
        round_up(top);
        const auto columns = static_cast<int>(std::floor(largest(right - left)));
        const auto rows = static_cast<int>(std::floor(largest(bottom - top)));
        for (int down = 0; down <= rows; ++down)
            for (int across = 0; across <= columns; ++across)
            {
                const Floats here_x = left + static_cast<float>(across), here_y = top + static_cast<float>(down);
                const Floats to_x = here_x - x[0], to_y = here_y - y[0];
                const Floats beside = (to_x * below_y - to_y * below_x) * share;
                const Floats below = (beside_x * to_y - beside_y * to_x) * share;
                const Floats joint = 1 - beside - below;
                const Floats weights = joint * weight[0] + beside * weight[1] + below * weight[2];
                const Ints inside = (joint >= -rounding) & (beside >= -rounding) & (below >= -rounding) & (weights > 0) &
                                    (here_x <= last) & (here_y <= last);
                const Ints texels =
                    __builtin_convertvector(here_y, Ints) * target_.size_px + __builtin_convertvector(here_x, Ints);
                const Floats at_x = (column + 0.5F + beside * rightward) * share_x_;
                const Floats at_y = (row + 0.5F + below * downward) * share_y_;
                make_room();
                DrawnSample* next = drawn_.data() + count_;
                for (std::size_t lane = 0; lane < lanes; ++lane)  // Without branches, which nobody could predict.
                {
                    *next = {static_cast<std::uint32_t>(texels[lane]), weights[lane], {at_x[lane], at_y[lane]}, covered[lane]};
                    next -= inside[lane];
                }
                count_ = static_cast<std::size_t>(next - drawn_.data());
            }
    }

    void splat(int x, int y)
    {
        const Pixel from = pixel(x, y);
        const int last = target_.size_px - 1;
        const auto left = static_cast<int>(std::floor(from.x));
        const auto top = static_cast<int>(std::floor(from.y));
        make_room();
        for (int row = std::max(0, top); row <= std::min(last, top + 1); ++row)
            for (int column = std::max(0, left); column <= std::min(last, left + 1); ++column)
            {
                const float share =
                    (1 - std::abs(from.x - static_cast<float>(column))) * (1 - std::abs(from.y - static_cast<float>(row)));
                if (share > 0)
                    drawn_[count_++] = {static_cast<std::uint32_t>(row * target_.size_px + column),
                                        beside_pixels * from.weight * share,
                                        {(static_cast<float>(x) + 0.5F) * share_x_, (static_cast<float>(y) + 0.5F) * share_y_},
                                        share_x_ * share_y_};
            }
    }

    /// For as many samples as there are lanes.
    void make_room()
    {
        if (drawn_.size() < count_ + lanes)
            drawn_.resize(2 * drawn_.size());
    }

    void sort_into_blocks()
    {
        for (std::size_t i = 0; i < count_; ++i)
            blocks_[drawn_[i].texel / texels_per_block_].push_back(drawn_[i]);
        count_ = 0;
    }

    /// Leaves one sample of each texel. `places`: none, per texel of a block.
    void keep_heaviest(std::size_t block, std::vector<std::uint32_t>& places)
    {
        auto& samples = blocks_[block];
        std::uint32_t kept = 0;
        for (const DrawnSample& sample : samples)
        {
            std::uint32_t& place = places[sample.texel - block * texels_per_block_];
            if (place == none)
                samples[place = kept++] = sample;
            else if (sample.weight > samples[place].weight)
                samples[place] = sample;
        }
        samples.resize(kept);
    }

    Triangles triangles_;  ///< Not drawn yet: the lanes before lane_.
    const UvMap& map_;
    const PixelLinks& links_;
    const RasterF& weight_;
    GatherTarget target_;
    float share_x_;  ///< Width of the map's pixels as a share of the picture.
    float share_y_;
    Raster8 whole_;                     ///< 1: the square up and left of this pixel is drawn whole.
    std::vector<Pixel> upper_, lower_;  ///< Two rows of pixels.
    std::size_t lane_ = 0;
    std::vector<DrawnSample> drawn_;  ///< The first count_ are not yet sorted into blocks.
    std::size_t count_ = 0;
    std::uint32_t texels_per_block_;
    std::vector<std::vector<DrawnSample>> blocks_;
};

}  // namespace

void gather(const UvMap& map, const PixelLinks& links, const RasterF& weight, const GatherTarget& target, const SampleUser& use)
{
    Gatherer(map, links, weight, target).gather(use);
}

}  // namespace fresco::from_frames

#include "gather.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fresco::from_frames
{
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
        const double footprint = std::sqrt(scale_x_ * scale_y_ / std::abs(area));
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
                    picture_.at(x * scale_x_, y * scale_y_, footprint));
            }
    }

    void splat(int x, int y)
    {
        const Corner pixel = corner(x, y);
        const int last = target_.size_px - 1;
        const auto left = static_cast<int>(std::floor(pixel.x));
        const auto top = static_cast<int>(std::floor(pixel.y));
        const auto rgb = picture_.at(pixel.column * scale_x_, pixel.row * scale_y_, std::sqrt(scale_x_ * scale_y_));
        for (int row = std::max(0, top); row <= std::min(last, top + 1); ++row)
            for (int column = std::max(0, left); column <= std::min(last, left + 1); ++column)
            {
                const double share = (1 - std::abs(pixel.x - column)) * (1 - std::abs(pixel.y - row));
                if (share > 0)
                    add(column, row, beside_pixels * pixel.weight * share, rgb);
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

    void add(int column, int row, double weight, const std::array<float, 3>& rgb)
    {
        const auto sample_weight = static_cast<float>(weight);
        if (sample_weight > 0)
            blocks_[static_cast<std::size_t>(row / target_.rows_per_block)].push_back(
                {static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(target_.size_px) +
                     static_cast<std::uint32_t>(column),
                 sample_weight, rgb});
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

#include "source_use.h"

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

using namespace fresco;

namespace
{
constexpr int most_cells = 8192;
constexpr int bins_per_window = 32;
constexpr double window_area = 0.01;

/// The picture cut into squares, the last of a row or column perhaps cut short.
class Squares
{
  public:
    Squares(const SourceMap& source, double side_x, double side_y)
        : side_x_(side_x), side_y_(side_y), columns_(count(source.picture_width, side_x)),
          rows_(count(source.picture_height, side_y)), texels_(columns_ * rows_)
    {
    }

    void add(Vec2f at) { ++texels_[square(double{at.y}, side_y_, rows_) * columns_ + square(double{at.x}, side_x_, columns_)]; }

    double used_share() const
    {
        const auto used = std::ranges::count_if(texels_, [](std::uint32_t count) { return count > 0; });
        return static_cast<double>(used) / static_cast<double>(texels_.size());
    }

    /// The most texels in any window of `side` x `side` squares within the picture.
    std::uint64_t fullest_window(std::size_t side) const
    {
        const std::size_t width = std::min(side, columns_);
        const std::size_t height = std::min(side, rows_);
        const std::vector<std::uint64_t> sums = sums_above_left();
        const auto sum = [&](std::size_t x, std::size_t y) { return sums[y * (columns_ + 1) + x]; };
        std::uint64_t most = 0;
        for (std::size_t y = 0; y + height <= rows_; ++y)
            for (std::size_t x = 0; x + width <= columns_; ++x)
                most = std::max(most, sum(x + width, y + height) - sum(x, y + height) - sum(x + width, y) + sum(x, y));
        return most;
    }

  private:
    static std::size_t count(int length, double side)
    {
        // A whole number of squares must not get another one by rounding.
        return static_cast<std::size_t>(std::max(1.0, std::ceil(length / side - 1e-6)));
    }
    static std::size_t square(double at, double side, std::size_t count)
    {
        return std::min(static_cast<std::size_t>(std::max(0.0, at / side)), count - 1);
    }
    std::vector<std::uint64_t> sums_above_left() const
    {
        std::vector<std::uint64_t> sums((columns_ + 1) * (rows_ + 1));
        for (std::size_t y = 0; y < rows_; ++y)
        {
            std::uint64_t row = 0;
            for (std::size_t x = 0; x < columns_; ++x)
            {
                row += texels_[y * columns_ + x];
                sums[(y + 1) * (columns_ + 1) + x + 1] = sums[y * (columns_ + 1) + x + 1] + row;
            }
        }
        return sums;
    }

    double side_x_;
    double side_y_;
    std::size_t columns_;
    std::size_t rows_;
    std::vector<std::uint32_t> texels_;
};
}  // namespace

SourceUse source_use(const SourceMap& source)
{
    const double width = source.picture_width;
    const double height = source.picture_height;
    const double cell = source.pixels_per_texel;
    const double bin = std::sqrt(window_area * width * height) / bins_per_window;
    Squares cells(source, std::max(cell, width / most_cells), std::max(cell, height / most_cells));
    Squares bins(source, bin, bin);
    SourceUse use;
    for (int y = 0; y < source.size_px(); ++y)
        for (int x = 0; x < source.size_px(); ++x)
            if (const auto place = source.place(x, y))
            {
                cells.add(place->at);
                bins.add(place->at);
                ++use.texels;
            }
    if (use.texels == 0)
        throw Error("the map on port 'source' has no texel from the picture: wire the map that belongs to the painted texture");
    use.picture_used = cells.used_share();
    use.largest_share = static_cast<double>(bins.fullest_window(bins_per_window)) / static_cast<double>(use.texels);
    return use;
}

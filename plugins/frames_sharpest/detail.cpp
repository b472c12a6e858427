#include "detail.h"

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
constexpr std::array<Step, directions_count> steps{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};

/// At most 12 bits, so that the squares of a block fit in 32.
Raster<std::int16_t> gray_of(const Raster8& rgb)
{
    Raster<std::int16_t> gray(rgb.width, rgb.height);
    for (std::size_t i = 0; i < gray.values.size(); ++i)
    {
        const std::uint8_t* pixel = &rgb.values[3 * i];
        gray.values[i] = static_cast<std::int16_t>((9798 * pixel[0] + 19235 * pixel[1] + 3735 * pixel[2] + (1 << 12)) >> 13);
    }
    return gray;
}

constexpr float levels_per_step = 4;

/// Of the pixels of a block whose partner is in the picture.
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

}  // namespace

double step_px(std::size_t direction)
{
    return direction < 2 ? 1 : std::numbers::sqrt2;
}

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
                    block.change[d][k] = mean_change(gray, left, top, {lags[k] * steps[d].x, lags[k] * steps[d].y});
            std::int64_t sum = 0;
            for (int y = top; y < top + block_px; ++y)
                for (int x = left; x < left + block_px; ++x)
                    sum += gray.at(x, y);
            block.gray = static_cast<float>(sum) / (levels_per_step * block_px * block_px);
        }
    return detail;
}

}  // namespace fresco::sharpest

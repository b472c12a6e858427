#include "maps.h"

#include <algorithm>
#include <array>
#include <vector>

namespace vgg19
{
namespace
{

std::size_t unsigned_of(int value)
{
    return static_cast<std::size_t>(value);
}

const winograd::Kernel& kernel()
{
    return Convolution3x3::fastest_kernel();
}

void masked_row(const float* own, const float* other, const std::uint8_t* mask, float* out, std::size_t count)
{
    if (own == nullptr && other == nullptr)
        std::fill_n(out, count, 0.0F);
    else
        kernel().mask_sum(own, other, mask, count, out);
}

}  // namespace

void from_planes(const float* planes, MapsShape shape, float* maps, const Parallel& parallel)
{
    constexpr std::size_t run = 64;
    const std::size_t pixels = shape.pixels();
    const auto stride = unsigned_of(shape.channels);
    parallel((pixels + run - 1) / run,
             [&](std::size_t begin, std::size_t end)
             {
                 for (std::size_t first = begin * run; first < std::min(pixels, end * run); first += run)
                 {
                     const std::size_t count = std::min(run, pixels - first);
                     for (std::size_t channel = 0; channel < stride; ++channel)
                     {
                         const float* from = planes + channel * pixels + first;
                         float* to = maps + first * stride + channel;
                         for (std::size_t i = 0; i < count; ++i)
                             to[i * stride] = from[i];
                     }
                 }
             });
}

void pool(const float* maps, MapsShape shape, Pooling pooling, float* out, std::uint8_t* chosen, const Parallel& parallel)
{
    const auto channels = unsigned_of(shape.channels);
    const std::size_t row = unsigned_of(shape.width) * channels;
    const std::size_t width = unsigned_of(shape.width) / 2;
    const auto mean = [&](const float* a, float* to)
    {
        const float* b = a + row;
        for (std::size_t c = 0; c < channels; ++c)
            to[c] = (a[c] + a[c + channels] + b[c] + b[c + channels]) / 4;
    };
    parallel(unsigned_of(shape.height) / 2,
             [&](std::size_t begin, std::size_t end)
             {
                 for (std::size_t y = begin; y < end; ++y)
                     for (std::size_t x = 0; x < width; ++x)
                     {
                         const float* first = maps + 2 * y * row + 2 * x * channels;
                         const std::size_t to = (y * width + x) * channels;
                         if (pooling == Pooling::average)
                             mean(first, out + to);
                         else
                             kernel().pool(first, first + row, shape.channels, out + to,
                                           chosen == nullptr ? nullptr : chosen + to);
                     }
             });
}

GradientView folded(float* framed, int height, int width, int channels)
{
    const auto c = unsigned_of(channels);
    const std::size_t row = (unsigned_of(width) + 2) * c;
    const auto add = [](const float* from, float* to, std::size_t count)
    {
        for (std::size_t i = 0; i < count; ++i)
            to[i] += from[i];
    };
    const auto reflected = [](int count) { return std::array<int, 2>{count == 1 ? 1 : 2, count == 1 ? 1 : count - 1}; };
    const auto rows = reflected(height);
    add(framed, framed + unsigned_of(rows[0]) * row, row);
    add(framed + (unsigned_of(height) + 1) * row, framed + unsigned_of(rows[1]) * row, row);
    const auto columns = reflected(width);
    for (std::size_t y = 1; y <= unsigned_of(height); ++y)
    {
        float* line = framed + y * row;
        add(line, line + unsigned_of(columns[0]) * c, c);
        add(line + (unsigned_of(width) + 1) * c, line + unsigned_of(columns[1]) * c, c);
    }
    return {framed + row + c, row};
}

void add_masked(MapsShape shape, const float* own, GradientView of_next, const std::uint8_t* mask, float* out,
                const Parallel& parallel)
{
    const std::size_t row = unsigned_of(shape.width) * unsigned_of(shape.channels);
    parallel(unsigned_of(shape.height),
             [&](std::size_t begin, std::size_t end)
             {
                 for (std::size_t y = begin; y < end; ++y)
                     masked_row(own == nullptr ? nullptr : own + y * row,
                                of_next.values == nullptr ? nullptr : of_next.values + y * of_next.row, mask + y * row,
                                out + y * row, row);
             });
}

void add_unpooled(MapsShape shape, const float* own, GradientView of_next, Pooling pooling, const std::uint8_t* chosen,
                  const std::uint8_t* mask, float* out, const Parallel& parallel)
{
    const auto channels = unsigned_of(shape.channels);
    const std::size_t row = unsigned_of(shape.width) * channels;
    const std::size_t width = unsigned_of(shape.width) / 2;
    const std::size_t height = unsigned_of(shape.height) / 2;
    const auto line = [&](std::size_t y)
    {
        // An odd last row or column is not pooled.
        const std::size_t pooled = y / 2 < height ? 2 * width : 0;
        std::vector<float> shares(row);
        for (std::size_t x = 0; x < pooled; ++x)
        {
            const float* from = of_next.values + y / 2 * of_next.row + x / 2 * channels;
            float* to = shares.data() + x * channels;
            if (pooling == Pooling::average)
                for (std::size_t c = 0; c < channels; ++c)
                    to[c] = 0.25F * from[c];
            else
                kernel().unpool(from, chosen + (y / 2 * width + x / 2) * channels, static_cast<std::uint8_t>(y % 2 * 2 + x % 2),
                                shape.channels, to);
        }
        masked_row(own == nullptr ? nullptr : own + y * row, shares.data(), mask + y * row, out + y * row, row);
    };
    parallel(unsigned_of(shape.height),
             [&](std::size_t begin, std::size_t end)
             {
                 for (std::size_t y = begin; y < end; ++y)
                     line(y);
             });
}

}  // namespace vgg19

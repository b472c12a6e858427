#include "convolution.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <vector>

namespace vgg19
{
namespace
{

constexpr int side = 6;         ///< Of the outputs of a tile.
constexpr int wide = side + 2;  ///< Of its inputs.
constexpr int positions = wide * wide;
constexpr std::size_t line = std::tuple_size_v<decltype(Line::values)>;

std::size_t unsigned_of(int value)
{
    return static_cast<std::size_t>(value);
}

int filled_up(int channels)
{
    constexpr int multiple = 16;
    return (channels + multiple - 1) / multiple * multiple;
}

/// G w Gᵀ: a filter's values at the positions.
std::array<double, positions> transformed(const std::array<double, 9>& w)
{
    const auto eight = [](double a, double b, double c)
    {
        return std::array<double, wide>{a,
                                        (a + b + c) * (-2 / 9.0),
                                        (a - b + c) * (-2 / 9.0),
                                        (a + 2 * b + 4 * c) * (2 / 45.0),
                                        (a - 2 * b + 4 * c) * (2 / 45.0),
                                        (4 * a + 2 * b + c) * (2 / 45.0),
                                        (4 * a - 2 * b + c) * (2 / 45.0),
                                        c};
    };
    std::array<std::array<double, wide>, 3> columns{};
    for (std::size_t x = 0; x < 3; ++x)
        columns[x] = eight(w[x], w[3 + x], w[6 + x]);
    std::array<double, positions> result{};
    for (std::size_t y = 0; y < wide; ++y)
    {
        const auto row = eight(columns[0][y], columns[1][y], columns[2][y]);
        std::copy(row.begin(), row.end(), result.begin() + static_cast<std::ptrdiff_t>(wide * y));
    }
    return result;
}

float* values_in(std::vector<Line>& lines)
{
    return lines.front().values.data();
}

const float* values_in(const std::vector<Line>& lines)
{
    return lines.front().values.data();
}

/// Of so many values at a position. Not a multiple of a page: a tile's values would all fall into one set of the first-level
/// cache.
std::size_t stride_of(std::size_t values)
{
    return values + line;
}

/// The pixel that stands for one beyond the border; -1: zero.
int beyond_border(int i, int count, Border border)
{
    if (i >= 0 && i < count)
        return i;
    // Rows of the last tiles that no output needs lie farther out.
    if (border == Border::zero || i < -1 || i > count)
        return -1;
    return count == 1 ? 0 : i < 0 ? 1 : count - 2;
}

}  // namespace

/// The first output of a tile.
struct Convolution3x3::Corner
{
    int y;
    int x;
};

/// What goes in and out of one run.
struct Convolution3x3::Job
{
    const float* in = nullptr;
    MapsShape shape;  ///< Of the input.
    Border border = Border::zero;
    int origin = 1;  ///< Output y reads the input rows y - origin … y - origin + 2.
    int height = 0;  ///< Of the output.
    int width = 0;
    const float* bias = nullptr;  ///< Null: neither bias nor rectifier.
    float* out = nullptr;
    std::uint8_t* masks = nullptr;
    std::vector<Corner> tiles = {};  ///< To be computed: their first outputs.

    std::size_t offset(int y, int x, int channels) const
    {
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels);
    }
    void clear(Corner tile, int channels) const;
    void choose_tiles(const std::uint8_t* needed, int channels, const Parallel& parallel);
};

/// Sets a tile's outputs to 0.
void Convolution3x3::Job::clear(Corner tile, int channels) const
{
    const auto count = static_cast<std::size_t>(std::min(side, width - tile.x)) * static_cast<std::size_t>(channels);
    for (int y = tile.y; y < std::min(height, tile.y + side); ++y)
    {
        std::fill_n(out + offset(y, tile.x, channels), count, 0.0F);
        if (masks != nullptr)
            std::fill_n(masks + offset(y, tile.x, channels), count, std::uint8_t{0});
    }
}

void Convolution3x3::Job::choose_tiles(const std::uint8_t* needed, int channels, const Parallel& parallel)
{
    const auto is_needed = [&](Corner tile)
    {
        for (int y = tile.y; needed != nullptr && y < std::min(height, tile.y + side); ++y)
            if (const auto* row = needed + offset(y, 0, 1);
                std::find_if(row + tile.x, row + std::min(width, tile.x + side), [](auto v) { return v != 0; }) !=
                row + std::min(width, tile.x + side))
                return true;
        return needed == nullptr;
    };
    std::vector<Corner> others;
    for (int y = 0; y < height; y += side)
        for (int x = 0; x < width; x += side)
            (is_needed({y, x}) ? tiles : others).push_back({y, x});
    parallel(others.size(),
             [&](std::size_t begin, std::size_t end)
             {
                 for (std::size_t i = begin; i < end; ++i)
                     clear(others[i], channels);
             });
}

const winograd::Kernel& Convolution3x3::fastest_kernel()
{
    static const auto& fastest = fresco::fastest_of(winograd::avx512_kernel(), winograd::avx2_kernel(), winograd::base_kernel());
    return fastest;
}

Convolution3x3::Convolution3x3(std::span<const float> weights, int outputs, int inputs, Way way, const winograd::Kernel& kernel)
    : kernel_(&kernel), terms_(way == Way::there ? inputs : outputs), inputs_(filled_up(terms_)),
      outputs_(filled_up(way == Way::there ? outputs : inputs)),
      filters_(positions * unsigned_of(terms_) * unsigned_of(outputs_) / line)
{
    const auto inner = unsigned_of(terms_);
    for (std::size_t output = 0; output < unsigned_of(way == Way::there ? outputs : inputs); ++output)
    {
        const auto panel = panel_of(output / unsigned_of(kernel_->panel));
        for (std::size_t input = 0; input < inner; ++input)
        {
            std::array<double, 9> filter{};
            const std::size_t number = way == Way::there ? output * inner + input : input * unsigned_of(inputs) + output;
            std::copy_n(weights.begin() + static_cast<std::ptrdiff_t>(number * 9), 9, filter.begin());
            if (way == Way::back)
                std::ranges::reverse(filter);
            float* to = values_in(filters_) + panel.first * positions * inner + input * panel.width + output - panel.first;
            for (const double value : transformed(filter))
            {
                *to = static_cast<float>(value);
                to += inner * panel.width;
            }
        }
    }
}

Convolution3x3::Panel Convolution3x3::panel_of(std::size_t number) const
{
    const auto widest = unsigned_of(kernel_->panel);
    return {number * widest, std::min(widest, unsigned_of(outputs_) - number * widest)};
}

void Convolution3x3::rectified(const float* in, MapsShape shape, Border border, const float* bias, float* out,
                               std::uint8_t* masks, const Parallel& parallel, const std::uint8_t* needed) const
{
    run({in, shape, border, 1, shape.height, shape.width, bias, out, masks}, needed, parallel);
}

void Convolution3x3::plain(const float* in, MapsShape shape, int beyond, float* out, const Parallel& parallel,
                           const std::uint8_t* needed) const
{
    run({in, shape, Border::zero, 1 + beyond, shape.height + 2 * beyond, shape.width + 2 * beyond, nullptr, out, nullptr}, needed,
        parallel);
}

/// Tiles that are worked on together, and their transformed values, position by position.
struct Convolution3x3::Block
{
    std::size_t first = 0;
    std::size_t last = 0;
    std::size_t count = 0;  ///< Filled up to what the kernel takes at once.
    float* values = nullptr;
    std::size_t stride = 0;  ///< From one position to the next.
};

Convolution3x3::Block Convolution3x3::block_of(std::size_t first, std::size_t last, std::vector<Line>& values) const
{
    const auto rows = unsigned_of(kernel_->rows);
    Block block{first, last, (last - first + rows - 1) / rows * rows};
    block.stride = stride_of(block.count * unsigned_of(inputs_));
    values.resize(std::max(values.size(), positions * block.stride / line));
    block.values = values_in(values);
    return block;
}

void Convolution3x3::run(Job job, const std::uint8_t* needed, const Parallel& parallel) const
{
    job.choose_tiles(needed, outputs_, parallel);
    const std::size_t tiles = job.tiles.size();
    const std::size_t panels = (unsigned_of(outputs_) + unsigned_of(kernel_->panel) - 1) / unsigned_of(kernel_->panel);
    constexpr int large = 256 * 256;
    constexpr std::size_t few = 288;
    if (inputs_ * outputs_ >= large && tiles <= few)
    {
        // Filters of many channels are larger than the pictures there: every one is read once, by one thread.
        constexpr std::size_t share = 8;
        thread_local std::vector<Line> values;
        const auto block = block_of(0, tiles, values);
        parallel((tiles + share - 1) / share,
                 [&](std::size_t begin, std::size_t end) { transform(job, block, begin * share, std::min(tiles, end * share)); });
        parallel(panels,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t panel = begin; panel < end; ++panel)
                         multiply(job, block, panel_of(panel));
                 });
        return;
    }
    // Many tiles share a pass over the filters. Where these are few, they and a block's values stay near the core.
    const std::size_t most = inputs_ * outputs_ < large ? 12 : 48;
    constexpr std::size_t fewest_blocks = 8;
    const auto rows = unsigned_of(kernel_->rows);
    const std::size_t share = (tiles + fewest_blocks - 1) / fewest_blocks;
    const std::size_t size = std::min(most, (share + rows - 1) / rows * rows);
    parallel(tiles == 0 ? 0 : (tiles + size - 1) / size,
             [&](std::size_t begin, std::size_t end)
             {
                 thread_local std::vector<Line> values;
                 for (std::size_t i = begin; i < end; ++i)
                 {
                     const auto block = block_of(i * size, std::min(tiles, (i + 1) * size), values);
                     transform(job, block, block.first, block.last);
                     for (std::size_t panel = 0; panel < panels; ++panel)
                         multiply(job, block, panel_of(panel));
                 }
             });
}

void Convolution3x3::transform(const Job& job, const Block& block, std::size_t first, std::size_t last) const
{
    const auto inner = static_cast<std::size_t>(inputs_);
    const std::vector<float> zeros(inner);
    using Pixels = std::array<const float*, positions>;
    const auto pixels_of = [&](std::size_t tile)
    {
        const int y0 = job.tiles[tile].y - job.origin;
        const int x0 = job.tiles[tile].x - job.origin;
        Pixels pixels{};
        for (int i = 0; i < positions; ++i)
        {
            const int y = beyond_border(y0 + i / wide, job.shape.height, job.border);
            const int x = beyond_border(x0 + i % wide, job.shape.width, job.border);
            pixels[static_cast<std::size_t>(i)] =
                y < 0 || x < 0 ? zeros.data()
                               : job.in + (static_cast<std::size_t>(y) * static_cast<std::size_t>(job.shape.width) +
                                           static_cast<std::size_t>(x)) *
                                              inner;
        }
        return pixels;
    };
    Pixels pixels = pixels_of(first);
    for (std::size_t tile = first; tile < last; ++tile)
    {
        const Pixels next = tile + 1 < last ? pixels_of(tile + 1) : pixels;
        kernel_->transform(pixels.data(), next.data(), inputs_, block.values + (tile - block.first) * inner, block.stride);
        pixels = next;
    }
}

void Convolution3x3::multiply(const Job& job, const Block& block, const Panel& panel) const
{
    thread_local std::vector<Line> products;
    const std::size_t stride = stride_of(block.count * panel.width);
    products.resize(std::max(products.size(), positions * stride / line));
    const std::size_t filters = unsigned_of(terms_) * panel.width;
    for (std::size_t position = 0; position < positions; ++position)
        kernel_->multiply(block.values + position * block.stride, static_cast<int>(block.count), inputs_, terms_,
                          values_in(filters_) + panel.first * positions * unsigned_of(terms_) + position * filters,
                          static_cast<int>(panel.width), values_in(products) + position * stride);
    for (std::size_t tile = block.first; tile < block.last; ++tile)
        transform_back(job, job.tiles[tile], panel, values_in(products) + (tile - block.first) * panel.width, stride);
}

void Convolution3x3::transform_back(const Job& job, Corner tile, const Panel& panel, const float* products,
                                    std::size_t stride) const
{
    const auto [y0, x0] = tile;
    const auto width = static_cast<int>(panel.width);
    std::array<float*, side * side> pixels{};
    std::array<std::uint8_t*, side * side> masks{};
    for (int i = 0; i < side * side; ++i)
    {
        const int y = y0 + i / side;
        const int x = x0 + i % side;
        if (y >= job.height || x >= job.width)
            continue;
        const std::size_t offset = job.offset(y, x, outputs_) + panel.first;
        pixels[static_cast<std::size_t>(i)] = job.out + offset;
        masks[static_cast<std::size_t>(i)] = job.masks == nullptr ? nullptr : job.masks + offset;
    }
    if (job.bias == nullptr)
        kernel_->transform_back(products, stride, width, pixels.data());
    else
        kernel_->rectify_back(products, stride, width, job.bias + panel.first, pixels.data(),
                              job.masks == nullptr ? nullptr : masks.data());
}

namespace
{

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

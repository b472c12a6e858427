#include "convolution.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <vector>

namespace vgg19
{
namespace
{

constexpr int side = 6;         ///< Outputs along a tile's side.
constexpr int wide = side + 2;  ///< Inputs along it.
constexpr int positions = wide * wide;
constexpr int widest_panel = 64;
constexpr std::size_t line = std::tuple_size_v<decltype(Line::values)>;

std::size_t unsigned_of(int value)
{
    return static_cast<std::size_t>(value);
}

std::size_t filled_up(std::size_t count, std::size_t multiple)
{
    return (count + multiple - 1) / multiple * multiple;
}

int filled_up(int channels)
{
    return static_cast<int>(filled_up(unsigned_of(channels), line));
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

/// Distance between two positions of `values` each. It avoids multiples of a page: a tile would use one set of the first-level
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

/// Inputs and outputs of one run.
struct Convolution3x3::Job
{
    MapsShape in_shape;
    const float* in = nullptr;  ///< Null: the way back.
    Border border = Border::zero;
    ResponseGradient gradient = {};
    int origin = 1;  ///< Output y reads the input rows y - origin … y - origin + 2.
    MapsShape out_shape = {};
    const float* bias = nullptr;  ///< Null: the way back, without rectifier and pooling.
    Responses out = {};
    std::vector<Corner> tiles = {};  ///< To be computed: their first outputs.

    void clear(Corner tile) const;
    void choose_tiles(const std::uint8_t* needed, const Parallel& parallel);
    void pool(Corner tile, const Panel& panel, const std::array<float*, side * side>& pixels,
              const winograd::Kernel& kernel) const;
};

/// Sets a tile's outputs to 0.
void Convolution3x3::Job::clear(Corner tile) const
{
    const auto fill = [&](auto* values, auto value, int cell)
    {
        const MapsShape shape = cell == 1 ? out_shape : out_shape.halved();
        const int columns = std::min(side / cell, shape.width - tile.x / cell);
        for (int y = tile.y / cell; values != nullptr && columns > 0 && y < std::min(shape.height, (tile.y + side) / cell); ++y)
            std::fill_n(values + shape.offset(y, tile.x / cell), columns * shape.channels, value);
    };
    fill(out.maps, 0.0F, 1);
    fill(out.masks, std::uint8_t{0}, 1);
    fill(out.pooled, 0.0F, 2);
    fill(out.chosen, std::uint8_t{4}, 2);
}

void Convolution3x3::Job::choose_tiles(const std::uint8_t* needed, const Parallel& parallel)
{
    const auto [height, width, channels] = out_shape;
    const auto is_needed = [&](Corner tile)
    {
        for (int y = tile.y; needed != nullptr && y < std::min(height, tile.y + side); ++y)
            if (const auto* row = needed + static_cast<std::ptrdiff_t>(y) * width;
                std::any_of(row + tile.x, row + std::min(width, tile.x + side), [](auto v) { return v != 0; }))
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
                     clear(others[i]);
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
    const auto there = unsigned_of(way == Way::there ? outputs : inputs);
    for (std::size_t number = 0; panel_of(number).first < there; ++number)
    {
        const auto [first, width] = panel_of(number);
        const std::size_t count = std::min(there - first, width);
        for (std::size_t input = 0; input < inner; ++input)
        {
            // The positions lie powers of two apart, in the same few sets of the caches: written as rows, not value by value.
            std::array<std::array<float, widest_panel>, positions> rows;
            for (std::size_t i = 0; i < count; ++i)
            {
                const std::size_t output = first + i;
                const std::size_t place = way == Way::there ? output * inner + input : input * there + output;
                std::array<double, 9> filter{};
                std::copy_n(weights.begin() + static_cast<std::ptrdiff_t>(place * 9), 9, filter.begin());
                if (way == Way::back)
                    std::ranges::reverse(filter);
                const auto values = transformed(filter);
                for (std::size_t position = 0; position < positions; ++position)
                    rows[position][i] = static_cast<float>(values[position]);
            }
            float* to = values_in(filters_) + first * positions * inner + input * width;
            for (const auto& row : rows)
            {
                std::copy_n(row.begin(), count, to);
                to += inner * width;
            }
        }
    }
}

Convolution3x3::Panel Convolution3x3::panel_of(std::size_t number) const
{
    const auto widest = unsigned_of(kernel_->panel);
    return {number * widest, std::min(widest, unsigned_of(outputs_) - number * widest)};
}

void Convolution3x3::rectified(const float* in, MapsShape shape, Border border, const float* bias, const Responses& out,
                               const Parallel& parallel, const std::uint8_t* needed) const
{
    run({.in_shape = shape,
         .in = in,
         .border = border,
         .out_shape = {shape.height, shape.width, outputs_},
         .bias = bias,
         .out = out},
        needed, parallel);
}

void Convolution3x3::back(const ResponseGradient& gradient, MapsShape shape, int beyond, float* out, const Parallel& parallel,
                          const std::uint8_t* needed) const
{
    run({.in_shape = shape,
         .gradient = gradient,
         .origin = 1 + beyond,
         .out_shape = {shape.height + 2 * beyond, shape.width + 2 * beyond, outputs_},
         .out = {.maps = out}},
        needed, parallel);
}

/// Tiles that are worked on together, and their transformed values, position by position.
struct Convolution3x3::Block
{
    std::size_t first = 0;
    std::size_t last = 0;
    float* values = nullptr;
    std::size_t stride = 0;  ///< From one position to the next.
};

Convolution3x3::Block Convolution3x3::block_of(std::size_t first, std::size_t last, std::vector<Line>& values) const
{
    Block block{first, last};
    block.stride = stride_of(filled_up(last - first, unsigned_of(kernel_->rows)) * unsigned_of(inputs_));
    values.resize(std::max(values.size(), positions * block.stride / line));
    block.values = values_in(values);
    return block;
}

void Convolution3x3::run(Job job, const std::uint8_t* needed, const Parallel& parallel) const
{
    job.choose_tiles(needed, parallel);
    const std::size_t tiles = job.tiles.size();
    const std::size_t panels = (unsigned_of(outputs_) + unsigned_of(kernel_->panel) - 1) / unsigned_of(kernel_->panel);
    constexpr int large = 256 * 256;
    if (inputs_ * outputs_ < large)
    {
        // The filters and a block's values stay near the core.
        constexpr std::size_t most = 12;
        parallel((tiles + most - 1) / most,
                 [&](std::size_t begin, std::size_t end)
                 {
                     thread_local std::vector<Line> values;
                     const auto block = block_of(begin * most, std::min(tiles, end * most), values);
                     transform(job, block, block.first, block.last);
                     for (std::size_t panel = 0; panel < panels; ++panel)
                         multiply(job, block, panel_of(panel));
                 });
        return;
    }
    // Filters of many channels do not: the more tiles share a pass over them, the better.
    constexpr std::size_t together = 576;
    constexpr std::size_t share = 8;
    thread_local std::vector<Line> values;
    for (std::size_t first = 0; first < tiles; first += together)
    {
        const auto block = block_of(first, std::min(tiles, first + together), values);
        const std::size_t count = block.last - first;
        parallel((count + share - 1) / share, [&](std::size_t begin, std::size_t end)
                 { transform(job, block, first + begin * share, std::min(block.last, first + end * share)); });
        constexpr std::size_t most = together / 3;
        const std::size_t pieces = (count + most - 1) / most;
        const std::size_t piece = filled_up((count + pieces - 1) / pieces, unsigned_of(kernel_->rows));
        parallel(panels * pieces,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                     {
                         Block part = block;
                         part.first = std::min(block.last, first + i / panels * piece);
                         part.last = std::min(block.last, part.first + piece);
                         part.values += (part.first - first) * unsigned_of(inputs_);
                         multiply(job, part, panel_of(i % panels));
                     }
                 });
    }
}

/// Calls transform(tile, the next tile, where its values go).
template <class Tile, class TileOf, class Transform>
void Convolution3x3::each_tile(const Block& block, std::size_t first, std::size_t last, const TileOf& tile_of,
                               const Transform& transform) const
{
    std::array<Tile, 2> tiles;
    tile_of(first, tiles[first % 2]);
    for (std::size_t tile = first; tile < last; ++tile)
    {
        tile_of(std::min(tile + 1, last - 1), tiles[(tile + 1) % 2]);
        transform(tiles[tile % 2], tiles[(tile + 1) % 2], block.values + (tile - block.first) * unsigned_of(inputs_));
    }
}

void Convolution3x3::transform(const Job& job, const Block& block, std::size_t first, std::size_t last) const
{
    const std::vector<float> zeros(unsigned_of(inputs_));
    const MapsShape& shape = job.in_shape;
    /// Calls put(i, y, x) for each pixel, none(i) for each beyond the border.
    const auto each_pixel = [&](std::size_t tile, const auto& put, const auto& none)
    {
        std::array<int, wide> rows{};
        std::array<int, wide> columns{};
        for (int i = 0; i < wide; ++i)
        {
            rows[unsigned_of(i)] = beyond_border(job.tiles[tile].y - job.origin + i, shape.height, job.border);
            columns[unsigned_of(i)] = beyond_border(job.tiles[tile].x - job.origin + i, shape.width, job.border);
        }
        std::size_t i = 0;
        for (const int y : rows)
            for (const int x : columns)
                y < 0 || x < 0 ? none(i++) : put(i++, y, x);
    };
    if (job.in != nullptr)
        return each_tile<std::array<const float*, positions>>(
            block, first, last,
            [&](std::size_t tile, auto& pixels)
            {
                each_pixel(
                    tile, [&](std::size_t i, int y, int x) { pixels[i] = job.in + shape.offset(y, x); },
                    [&](std::size_t i) { pixels[i] = zeros.data(); });
            },
            [&](const auto& pixels, const auto& next, float* out)
            { kernel_->transform(pixels.data(), next.data(), inputs_, out, block.stride); });

    const auto& [own, of_next, masks, chosen] = job.gradient;
    const bool pooled = chosen != nullptr;
    const auto* no_bytes = reinterpret_cast<const std::uint8_t*>(zeros.data());
    const MapsShape small = shape.halved();
    const auto put = [&](winograd::GradientTile& pixels, std::size_t i, int y, int x)
    {
        const std::size_t offset = shape.offset(y, x);
        const int sy = pooled ? y / 2 : y;
        const int sx = pooled ? x / 2 : x;
        // An odd last row or column is not pooled.
        const bool has_next = of_next.values != nullptr && (!pooled || (sy < small.height && sx < small.width));
        pixels.next[i] =
            has_next ? of_next.values + unsigned_of(sy) * of_next.row + unsigned_of(sx * shape.channels) : zeros.data();
        pixels.chosen[i] = !has_next ? no_bytes : pooled ? chosen + small.offset(sy, sx) : masks + offset;
        pixels.number[i] = static_cast<std::uint8_t>(pooled ? y % 2 * 2 + x % 2 : 1);
        if (own == nullptr)
            return;
        pixels.own[i] = own + offset;
        pixels.mask[i] = masks + offset;
    };
    each_tile<winograd::GradientTile>(
        block, first, last,
        [&](std::size_t tile, winograd::GradientTile& pixels)
        {
            each_pixel(
                tile, [&](std::size_t i, int y, int x) { put(pixels, i, y, x); },
                [&](std::size_t i)
                {
                    pixels.next[i] = pixels.own[i] = zeros.data();
                    pixels.chosen[i] = pixels.mask[i] = no_bytes;
                    pixels.number[i] = 1;
                });
        },
        [&](const auto& pixels, const auto& next, float* out)
        { kernel_->transform_gradient(pixels, next, own != nullptr, inputs_, out, block.stride); });
}

void Convolution3x3::multiply(const Job& job, const Block& block, const Panel& panel) const
{
    thread_local std::vector<Line> products;
    const std::size_t count = filled_up(block.last - block.first, unsigned_of(kernel_->rows));
    const std::size_t stride = stride_of(count * panel.width);
    products.resize(std::max(products.size(), positions * stride / line));
    const std::size_t filters = unsigned_of(terms_) * panel.width;
    for (std::size_t position = 0; position < positions; ++position)
        kernel_->multiply(block.values + position * block.stride, static_cast<int>(count), inputs_, terms_,
                          values_in(filters_) + panel.first * positions * unsigned_of(terms_) + position * filters,
                          static_cast<int>(panel.width), values_in(products) + position * stride);
    for (std::size_t tile = block.first; tile < block.last; ++tile)
        transform_back(job, job.tiles[tile], panel, values_in(products) + (tile - block.first) * panel.width, stride);
}

void Convolution3x3::transform_back(const Job& job, Corner tile, const Panel& panel, const float* products,
                                    std::size_t stride) const
{
    const auto width = static_cast<int>(panel.width);
    // Holds the responses of a tile that are needed only for pooling.
    std::array<Line, side * side * widest_panel / line> apart;
    std::array<float*, side * side> pixels{};
    std::array<std::uint8_t*, side * side> masks{};
    for (std::size_t i = 0; i < pixels.size(); ++i)
    {
        const int y = tile.y + static_cast<int>(i) / side;
        const int x = tile.x + static_cast<int>(i) % side;
        if (y >= job.out_shape.height || x >= job.out_shape.width)
            continue;
        const std::size_t offset = job.out_shape.offset(y, x) + panel.first;
        pixels[i] = job.out.maps == nullptr ? apart[0].values.data() + i * panel.width : job.out.maps + offset;
        masks[i] = job.out.masks == nullptr ? nullptr : job.out.masks + offset;
    }
    kernel_->transform_back(products, stride, width, job.bias == nullptr ? nullptr : job.bias + panel.first, pixels.data(),
                            job.out.masks == nullptr ? nullptr : masks.data());
    if (job.out.pooled != nullptr)
        job.pool(tile, panel, pixels, *kernel_);
}

void Convolution3x3::Job::pool(Corner tile, const Panel& panel, const std::array<float*, side * side>& pixels,
                               const winograd::Kernel& kernel) const
{
    const MapsShape shape = out_shape.halved();
    for (std::size_t i = 0; i < pixels.size(); i += i % side == side - 2 ? side + 2 : 2)
    {
        const int y = tile.y / 2 + static_cast<int>(i) / side / 2;
        const int x = tile.x / 2 + static_cast<int>(i) % side / 2;
        if (y >= shape.height || x >= shape.width)
            continue;
        const std::array<const float*, 4> four{pixels[i], pixels[i + 1], pixels[i + side], pixels[i + side + 1]};
        const std::size_t offset = shape.offset(y, x) + panel.first;
        kernel.pool(four.data(), static_cast<int>(panel.width), out.pooled + offset,
                    out.chosen == nullptr ? nullptr : out.chosen + offset);
    }
}

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

}  // namespace vgg19

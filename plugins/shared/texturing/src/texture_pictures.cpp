#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace fresco::texturing
{

namespace
{
constexpr std::array<float, 3> network_mean_bgr{103.939F, 116.779F, 123.68F};

using Tap = numerics::Between<float>;

/// The two source texels of each full-size texel center along one axis.
std::vector<Tap> taps(int size, int layer_size)
{
    std::vector<Tap> result;
    for (int i = 0; i < size; ++i)
        result.push_back(numerics::between<float>((i + 0.5) * layer_size / size - 0.5, layer_size));
    return result;
}

void add_row(const RasterF& layer, const std::vector<Tap>& taps, int y, std::vector<float>& row)
{
    if (layer.width == static_cast<int>(taps.size()))
    {
        const float* const from = &layer.values[static_cast<std::size_t>(y) * row.size()];
        for (std::size_t i = 0; i < row.size(); ++i)
            row[i] += from[i];
        return;
    }
    const Tap& vertical = taps[static_cast<std::size_t>(y)];
    for (std::size_t x = 0; x < taps.size(); ++x)
        for (int c = 0; c < 3; ++c)
            row[3 * x + static_cast<std::size_t>(c)] +=
                numerics::bilinear(taps[x], vertical, [&](int column, int line) { return layer.at(column, line, c); });
}

/// BGR around the network's mean to RGB in 0..1.
void network_to_rgb(std::vector<float>& row)
{
    for (std::size_t i = 0; i < row.size(); i += 3)
    {
        const std::array<float, 3> bgr{row[i], row[i + 1], row[i + 2]};
        for (std::size_t c = 0; c < 3; ++c)
            row[i + c] = (bgr[2 - c] + network_mean_bgr[2 - c]) / 255;
    }
}
}  // namespace

void check_texture(const Texture& texture)
{
    if (texture.values != "display" && texture.values != "network")
        throw Error("the texture's values are \"" + texture.values + "\"; expected \"display\" or \"network\"");
    if (texture.layers.empty())
        throw Error("the texture has no layers");
    const int size = texture.size_px();
    for (std::size_t i = 0; i < texture.layers.size(); ++i)
    {
        const RasterF& layer = texture.layers[i];
        if (layer.channels != 3 || layer.width < 1 || layer.width != layer.height || i >= 31 || layer.width != size >> i ||
            layer.width << i != size)
            throw Error(fmt::format("texture layer {} is {}x{}x{}; expected a square of side {} / 2^{} with 3 channels", i,
                                    layer.width, layer.height, layer.channels, size, i));
    }
    if (texture.seen.width != size || texture.seen.height != size || texture.seen.channels != 1)
        throw Error(
            fmt::format("the texture's seen mask is {}x{}; expected {}x{}", texture.seen.width, texture.seen.height, size, size));
}

RasterF collapse(const Texture& texture, const Progress& progress)
{
    const int size = texture.size_px();
    std::vector<std::vector<Tap>> layer_taps;
    for (const RasterF& layer : texture.layers)
        layer_taps.push_back(taps(size, layer.width));

    RasterF result(size, size, 3);
    const auto sum_row = [&](int y, std::vector<float>& row)
    {
        row.assign(static_cast<std::size_t>(size) * 3, 0.0F);
        for (std::size_t i = 0; i < texture.layers.size(); ++i)
            add_row(texture.layers[i], layer_taps[i], y, row);
        if (texture.values == "network")
            network_to_rgb(row);
        float* target = &result.at(0, y);
        for (std::size_t i = 0; i < row.size(); ++i)
        {
            if (!std::isfinite(row[i]))
                throw Error(fmt::format(
                    "the texture is not finite at texel ({}, {}): the optimization diverged; use a lower learning rate", i / 3,
                    y));
            target[i] = std::clamp(row[i], 0.0F, 1.0F);
        }
    };
    constexpr std::size_t rows_per_block = 32;
    parallel_for(static_cast<std::size_t>(size), rows_per_block, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<float> row;
                     for (std::size_t y = begin; y < end; ++y)
                         sum_row(static_cast<int>(y), row);
                 });
    return result;
}

Raster8 to_bytes(const RasterF& rgb, const Progress& progress)
{
    Raster8 bytes(rgb.width, rgb.height, rgb.channels);
    constexpr std::size_t values_per_block = std::size_t{1} << 18U;
    parallel_items(rgb.values.size(), values_per_block, progress,
                   [&](std::size_t i)
                   { bytes.values[i] = static_cast<std::uint8_t>(std::clamp(rgb.values[i], 0.0F, 1.0F) * 255.0F + 0.5F); });
    return bytes;
}

namespace
{

double curve(double display)
{
    return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}

/// Light at each step, or half-way to the next.
template <std::size_t Count>
std::array<double, Count> lights(double shift)
{
    std::array<double, Count> result;
    for (std::size_t i = 0; i < Count; ++i)
        result[i] = curve((static_cast<double>(i) + shift) / 255);
    return result;
}

}  // namespace

double to_linear(std::uint8_t step)
{
    static const auto table = lights<256>(0);
    return table[step];
}

std::uint8_t from_linear(double light)
{
    static const auto borders = lights<255>(0.5);
    // How many borders are below each of evenly spaced lights: at most a few more are to be passed.
    constexpr std::size_t starts_count = 1024;
    static const auto starts = []
    {
        std::array<std::uint8_t, starts_count + 1> result;
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = static_cast<std::uint8_t>(std::ranges::upper_bound(borders, static_cast<double>(i) / starts_count) -
                                                  borders.begin());
        return result;
    }();
    std::size_t step = starts[static_cast<std::size_t>(std::clamp(light, 0.0, 1.0) * starts_count)];
    while (step < borders.size() && borders[step] <= light)
        ++step;
    return static_cast<std::uint8_t>(step);
}

double displayed(double light)
{
    const double inside = std::clamp(light, 0.0, 1.0);
    return inside <= 0.0031308 ? 12.92 * inside : 1.055 * std::pow(inside, 1 / 2.4) - 0.055;
}

namespace
{
constexpr int no_row = std::numeric_limits<int>::max();
constexpr std::size_t columns_per_block = 64;

/// W x H: the row of the nearest source in the same column, or no_row.
std::vector<int> nearest_rows(const Raster8& image, const std::vector<std::uint8_t>& is_source, const Progress& progress)
{
    const auto width = static_cast<std::size_t>(image.width);
    std::vector<int> rows(is_source.size(), no_row);
    const auto nearer = [](int row, int candidate, int current)
    { return candidate != no_row && (current == no_row || std::abs(candidate - row) < std::abs(current - row)); };
    parallel_for(width, columns_per_block, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (int y = 0; y < image.height; ++y)
                         for (std::size_t x = begin; x < end; ++x)
                         {
                             const std::size_t at = static_cast<std::size_t>(y) * width + x;
                             rows[at] = is_source[at] ? y : y > 0 ? rows[at - width] : no_row;
                         }
                     for (int y = image.height - 2; y >= 0; --y)
                         for (std::size_t x = begin; x < end; ++x)
                         {
                             const std::size_t at = static_cast<std::size_t>(y) * width + x;
                             if (nearer(y, rows[at + width], rows[at]))
                                 rows[at] = rows[at + width];
                         }
                 });
    return rows;
}

/// The lower envelope of one parabola per column that holds a source: which column is nearest where along the row.
class Envelope
{
  public:
    explicit Envelope(std::size_t width) : columns_(width), begins_(width) {}

    void build(const int* nearest_row, std::size_t width, int row)
    {
        count_ = 0;
        for (std::size_t x = 0; x < width; ++x)
            if (nearest_row[x] != no_row)
                add(static_cast<double>(x), nearest_row, row);
    }

    /// For x in ascending order; `piece` starts at 0 and is kept by the caller.
    std::size_t column(double x, std::size_t& piece) const
    {
        while (piece + 1 < count_ && begins_[piece + 1] < x)
            ++piece;
        return columns_[piece];
    }

  private:
    void add(double x, const int* nearest_row, int row)
    {
        const auto height = [&](double column)
        {
            const double away = nearest_row[static_cast<std::size_t>(column)] - row;
            return away * away + column * column;
        };
        double begin = -std::numeric_limits<double>::infinity();
        while (count_ > 0)
        {
            const auto last = static_cast<double>(columns_[count_ - 1]);
            begin = (height(x) - height(last)) / (2 * (x - last));
            if (begin > begins_[count_ - 1])
                break;
            --count_;
        }
        if (count_ == 0)
            begin = -std::numeric_limits<double>::infinity();
        columns_[count_] = static_cast<std::size_t>(x);
        begins_[count_++] = begin;
    }

    std::vector<std::size_t> columns_;
    std::vector<double> begins_;
    std::size_t count_ = 0;
};
}  // namespace

void fill_from_nearest(Raster8& image, const std::vector<std::uint8_t>& is_source, const Progress& progress)
{
    if (std::find(is_source.begin(), is_source.end(), std::uint8_t{1}) == is_source.end())
        throw Error("the mesh's charts cover no texel: its texcoords lie outside [0,1] or are all the same");
    const std::vector<int> rows = nearest_rows(image, is_source, progress);
    const auto width = static_cast<std::size_t>(image.width);
    const auto channels = static_cast<std::size_t>(image.channels);
    constexpr std::size_t rows_per_block = 32;
    parallel_for(static_cast<std::size_t>(image.height), rows_per_block, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     Envelope envelope(width);
                     for (std::size_t y = begin; y < end; ++y)
                     {
                         const int* row = &rows[y * width];
                         envelope.build(row, width, static_cast<int>(y));
                         std::size_t piece = 0;
                         for (std::size_t x = 0; x < width; ++x)
                         {
                             if (is_source[y * width + x])
                                 continue;
                             const std::size_t column = envelope.column(static_cast<double>(x), piece);
                             const std::size_t source = static_cast<std::size_t>(row[column]) * width + column;
                             std::copy_n(&image.values[source * channels], channels, &image.values[(y * width + x) * channels]);
                         }
                     }
                 });
}

OpaquePicture opaque_picture(const Raster8& picture, const std::string& source, const Progress& progress)
{
    OpaquePicture result{Raster8(picture.width, picture.height, 3), Raster8(picture.width, picture.height)};
    std::vector<std::uint8_t> is_opaque(result.opaque.values.size());
    for (std::size_t i = 0; i < is_opaque.size(); ++i)
    {
        std::copy_n(&picture.values[4 * i], 3, &result.rgb.values[3 * i]);
        is_opaque[i] = picture.values[4 * i + 3] >= least_opaque_alpha ? 1 : 0;
        result.opaque.values[i] = is_opaque[i] != 0 ? 255 : 0;
    }
    if (std::ranges::find(is_opaque, 1) == is_opaque.end())
        throw Error(source + ": the picture is transparent everywhere; use one with opaque parts");
    fill_from_nearest(result.rgb, is_opaque, progress);
    return result;
}

namespace
{

/// Averages the texels of one chart below a texel of the smaller pictures.
class BoxFilter
{
  public:
    BoxFilter(std::span<const Raster8> sources, const TexelFaces& faces, const Charts& charts, int size, Steps steps)
        : sources_(sources), faces_(faces), charts_(charts), scale_(static_cast<double>(faces.size) / size), steps_(steps)
    {
        for (std::size_t step = 0; step < light_.size(); ++step)
            light_[step] = steps == Steps::light ? to_linear(static_cast<std::uint8_t>(step)) : static_cast<double>(step);
    }

    /// Writes one texel of all pictures; false where the box holds no texel of the chart.
    bool average(int x, int y, std::uint32_t chart, std::span<Raster8> smaller)
    {
        found_.clear();
        double weight = 0;
        const auto [first_row, end_row] = range(y);
        const auto [first_column, end_column] = range(x);
        for (int row = first_row; row < end_row; ++row)
            for (int column = first_column; column < end_column; ++column)
            {
                const auto texel =
                    static_cast<std::size_t>(row) * static_cast<std::size_t>(faces_.size) + static_cast<std::size_t>(column);
                if (faces_.inside[texel] == 0 || charts_.of_face[faces_.face[texel]] != chart)
                    continue;
                found_.emplace_back(texel, overlap(y, row) * overlap(x, column));
                weight += found_.back().second;
            }
        if (weight <= 0)
            return false;
        for (std::size_t i = 0; i < sources_.size(); ++i)
        {
            const auto channels = static_cast<std::size_t>(sources_[i].channels);
            const std::uint8_t* const values = sources_[i].values.data();
            std::array<double, 4> sum{};
            for (const auto& [texel, area] : found_)
                for (std::size_t c = 0; c < channels; ++c)
                    sum[c] += area * light_[values[texel * channels + c]];
            for (std::size_t c = 0; c < channels; ++c)
                smaller[i].at(x, y, static_cast<int>(c)) = steps_ == Steps::light
                                                               ? from_linear(sum[c] / weight)
                                                               : static_cast<std::uint8_t>(std::lround(sum[c] / weight));
        }
        return true;
    }

  private:
    std::pair<int, int> range(int at) const
    {
        return {static_cast<int>(at * scale_), std::min(faces_.size, static_cast<int>(std::ceil((at + 1) * scale_)))};
    }
    /// Overlap of the target texel `at` with the source texel `of`, along one axis.
    double overlap(int at, int of) const { return std::min((at + 1) * scale_, of + 1.0) - std::max(at * scale_, double(of)); }

    std::span<const Raster8> sources_;
    const TexelFaces& faces_;
    const Charts& charts_;
    double scale_;
    Steps steps_;
    std::array<double, 256> light_;                      ///< Linear light of the steps.
    std::vector<std::pair<std::size_t, double>> found_;  ///< The chart's texels in the box, and their areas in it.
};

}  // namespace

std::vector<Raster8> smaller_pictures(const Mesh& mesh, const Charts& charts, const TexelFaces& faces,
                                      std::span<const Raster8> pictures, int max_px, const Progress& progress, Steps steps)
{
    if (max_px == 0 || faces.size <= max_px)
        return {pictures.begin(), pictures.end()};
    const TexelFaces smaller = find_texel_faces(mesh, charts, max_px, progress);
    std::vector<Raster8> results;
    for (const Raster8& picture : pictures)
        results.emplace_back(max_px, max_px, picture.channels);
    std::vector<std::uint8_t> is_source(smaller.face.size(), 0);
    const auto size = static_cast<std::size_t>(max_px);
    constexpr std::size_t rows_per_block = 16;
    parallel_for(size, rows_per_block, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     BoxFilter filter(pictures, faces, charts, max_px, steps);
                     for (std::size_t texel = begin * size; texel < end * size; ++texel)
                         if (smaller.covered(texel))
                             is_source[texel] = filter.average(static_cast<int>(texel % size), static_cast<int>(texel / size),
                                                               charts.of_face[smaller.face[texel]], results);
                 });
    for (Raster8& result : results)
        fill_from_nearest(result, is_source, progress);
    return results;
}

Raster8 smaller_picture(const TexturedMesh& textured, int max_px, const Progress& progress)
{
    const Raster8& picture = textured.image.pixels;
    const Charts charts = find_charts(textured.mesh);
    const TexelFaces faces = find_texel_faces(textured.mesh, charts, picture.width, progress);
    return std::move(smaller_pictures(textured.mesh, charts, faces, {&picture, 1}, max_px, progress).front());
}

}  // namespace fresco::texturing

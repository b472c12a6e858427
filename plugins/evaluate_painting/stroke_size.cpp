#include "stroke_size.h"

#include <fresco/error.h>
#include <fresco/images/stroke_width.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <fmt/format.h>
#include <limits>
#include <numbers>

using namespace fresco;

namespace
{
constexpr int swatch_side = Swatch::samples;
constexpr double strokes_per_side = 5;
constexpr double finest_sigma =
    0.1 * swatch_side / strokes_per_side;  // In samples: sigma of the Gaussian that finer detail is left out by …
constexpr double broadest_sigma = swatch_side / strokes_per_side;  // … and of the one that is subtracted.
constexpr std::size_t least_swatches = 4;
constexpr int bins_per_cycle = 4;
constexpr int spectrum_bins = swatch_side * bins_per_cycle;
constexpr int steps_per_sample = 4;
constexpr int distance_steps = swatch_side / 2 * steps_per_sample;
constexpr int distance_cells = 512;
constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

using Line = std::array<std::complex<double>, swatch_side>;
/// Energy by frequency, a bin per 1 / bins_per_cycle of a cycle along a swatch's side.
using Spectrum = std::array<double, spectrum_bins>;

/// exp(-i pi k / half) at half + k, for half = 1, 2, 4 …
const Line& turns()
{
    static const Line values = []
    {
        Line table{};
        for (std::size_t half = 1; half < swatch_side; half *= 2)
            for (std::size_t k = 0; k < half; ++k)
                table[half + k] = std::polar(1.0, -std::numbers::pi * static_cast<double>(k) / static_cast<double>(half));
        return table;
    }();
    return values;
}

/// Discrete Fourier transform, in place: radix 2, by decimation in time.
void transform(Line& line)
{
    for (std::size_t i = 1, j = 0; i < swatch_side; ++i)
    {
        std::size_t bit = swatch_side / 2;
        for (; (j & bit) != 0; bit /= 2)
            j ^= bit;
        j ^= bit;
        if (i < j)
            std::swap(line[i], line[j]);
    }
    for (std::size_t half = 1; half < swatch_side; half *= 2)
        for (std::size_t k = 0; k < half; ++k)
            for (std::size_t i = k; i < swatch_side; i += 2 * half)
            {
                const std::complex<double> odd = line[i + half] * turns()[half + k];
                line[i + half] = line[i] - odd;
                line[i] += odd;
            }
}

/// L* less its mean and slopes, faded out toward the border.
std::array<Line, swatch_side> tapered(const RasterF& light)
{
    double mean = 0, across = 0, along = 0, norm = 0;
    const auto offset = [](int i) { return i - (swatch_side - 1) / 2.0; };
    for (int y = 0; y < swatch_side; ++y)
        for (int x = 0; x < swatch_side; ++x)
        {
            const double v = double{light.at(x, y)};
            mean += v;
            across += v * offset(x);
            along += v * offset(y);
            norm += offset(x) * offset(x);
        }
    mean /= swatch_side * swatch_side;
    across /= norm;
    along /= norm;
    const auto window = [](int i) { return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i + 1) / (swatch_side + 1)); };
    std::array<Line, swatch_side> result;
    for (int y = 0; y < swatch_side; ++y)
        for (int x = 0; x < swatch_side; ++x)
            result[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] =
                (double{light.at(x, y)} - mean - across * offset(x) - along * offset(y)) * window(x) * window(y);
    return result;
}

/// Of the detail between `finest_sigma` and `broadest_sigma`, from all directions.
Spectrum spectrum_of(const RasterF& light)
{
    std::array<Line, swatch_side> rows = tapered(light);
    for (Line& row : rows)
        transform(row);
    Spectrum result{};
    for (std::size_t x = 0; x < swatch_side; ++x)
    {
        Line column;
        for (std::size_t y = 0; y < swatch_side; ++y)
            column[y] = rows[y][x];
        transform(column);
        for (std::size_t y = 0; y < swatch_side; ++y)
        {
            const auto cycles = [](std::size_t i)
            { return i <= swatch_side / 2 ? static_cast<double>(i) : static_cast<double>(i) - swatch_side; };
            const double frequency = std::hypot(cycles(x), cycles(y));
            const double square = 2 * std::numbers::pi * std::numbers::pi * frequency * frequency / (swatch_side * swatch_side);
            const double kept =
                (1 - std::exp(-square * broadest_sigma * broadest_sigma)) * std::exp(-square * finest_sigma * finest_sigma);
            result[static_cast<std::size_t>(std::lround(frequency * bins_per_cycle))] += std::norm(column[y]) * kept * kept;
        }
    }
    return result;
}

/// J0 at every step of distance and bin: a wave's autocorrelation, averaged over its directions.
const std::vector<double>& wave_means()
{
    static const std::vector<double> values = []
    {
        std::vector<double> table(std::size_t{distance_steps} * spectrum_bins);
        for (int s = 0; s < distance_steps; ++s)
            for (int b = 0; b < spectrum_bins; ++b)
                table[static_cast<std::size_t>(s * spectrum_bins + b)] = std::cyl_bessel_j(
                    0.0, 2 * std::numbers::pi * s * b / (double{swatch_side} * steps_per_sample * bins_per_cycle));
        return table;
    }();
    return values;
}

double half_width(const Spectrum& spectrum)
{
    double all = 0;
    for (const double energy : spectrum)
        all += energy;
    if (!(all > 1e-6))
        return not_measured;
    double before = 1;
    for (int s = 1; s < distance_steps; ++s)
    {
        double sum = 0;
        for (int b = 0; b < spectrum_bins; ++b)
            sum += spectrum[static_cast<std::size_t>(b)] * wave_means()[static_cast<std::size_t>(s * spectrum_bins + b)];
        const double now = sum / all;
        if (now <= 0.5)
            return (s - (0.5 - now) / (before - now)) / steps_per_sample;
        before = now;
    }
    return not_measured;
}

Spectrum sum_of(const std::vector<Spectrum>& all)
{
    Spectrum result{};
    for (const Spectrum& one : all)
        for (std::size_t b = 0; b < result.size(); ++b)
            result[b] += one[b];
    return result;
}

std::vector<Spectrum> spectra_of(const std::vector<Swatch>& swatches)
{
    std::vector<Spectrum> result;
    for (const Swatch& swatch : swatches)
        result.push_back(spectrum_of(swatch.light));
    return result;
}
}  // namespace

double half_width(const std::vector<Swatch>& swatches)
{
    return half_width(sum_of(spectra_of(swatches)));
}

RasterF capture_distances(const UvMaps& uvmaps, int cells_px, const Progress& progress)
{
    std::vector<double> sums(static_cast<std::size_t>(cells_px) * static_cast<std::size_t>(cells_px), 0.0);
    std::vector<double> counts(sums.size(), 0.0);
    for (std::size_t view = 0; view < uvmaps.views.size(); ++view)
    {
        progress.check_canceled();
        const UvMap map = uvmaps.load_map(view, uvmaps.heights_px.size() - 1);
        for (std::size_t i = 0; i < map.valid.values.size(); ++i)
        {
            if (map.valid.values[i] == 0)
                continue;
            const auto cell = [&](float at)
            { return std::clamp(static_cast<int>(at * static_cast<float>(cells_px)), 0, cells_px - 1); };
            const auto place = static_cast<std::size_t>(cell(map.uv.values[2 * i + 1]) * cells_px + cell(map.uv.values[2 * i]));
            sums[place] += double{map.depth.values[i]};
            ++counts[place];
        }
    }
    RasterF result(cells_px, cells_px);
    for (std::size_t i = 0; i < sums.size(); ++i)
        result.values[i] = counts[i] > 0 ? static_cast<float>(sums[i] / counts[i]) : 0.0F;
    return result;
}

StrokeSize stroke_size(const TexturedMesh& painting, const Raster8& style, double stroke_cm, const UvMaps* uvmaps,
                       const Progress& progress)
{
    const std::vector<Swatch> in_picture = picture_swatches(style, strokes_per_side * stroke_width_px(style, progress));
    const std::vector<Spectrum> picture_spectra = spectra_of(in_picture);
    const double picture_width = half_width(sum_of(picture_spectra));
    if (std::isnan(picture_width))
        throw Error(fmt::format("the picture on port 'style' is {} x {}: smaller than {:g} of its strokes, or of one color, so "
                                "that there is no size to compare with; use a larger one",
                                style.width, style.height, strokes_per_side));
    const double side_m = strokes_per_side * stroke_cm / 100;
    const std::vector<Swatch> swatches = surface_swatches(painting.mesh, painting.image.pixels, side_m, progress);
    const std::vector<Spectrum> spectra = spectra_of(swatches);
    StrokeSize result{not_measured, {}, swatches.size()};
    if (swatches.size() < least_swatches)
        return result;
    result.stroke_cm = stroke_cm * half_width(sum_of(spectra)) / picture_width;
    if (uvmaps == nullptr)
        return result;

    std::vector<ColoredSize> picture_sizes;
    for (std::size_t i = 0; i < in_picture.size(); ++i)
        if (const double size = half_width(picture_spectra[i]); !std::isnan(size))
            picture_sizes.push_back({in_picture[i].color, std::log(size)});
    const RasterF distances = capture_distances(*uvmaps, distance_cells, progress);
    std::vector<PlacedSize> sizes;
    for (std::size_t i = 0; i < swatches.size(); ++i)
    {
        const auto cell = [](float at) { return std::min(static_cast<int>(at * distance_cells), distance_cells - 1); };
        const float distance = distances.at(cell(swatches[i].texcoord.x), cell(swatches[i].texcoord.y));
        const double size = half_width(spectra[i]);
        if (distance > 0 && !std::isnan(size))
            sizes.push_back({swatches[i].point, double{distance}, {swatches[i].color, std::log(size)}});
    }
    result.by_distance = size_by_distance(sizes, picture_sizes, side_m);
    return result;
}

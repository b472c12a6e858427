#include "stroke_size.h"

#include <fresco/error.h>
#include <fresco/evaluation/statistics.h>
#include <fresco/images/lab.h>
#include <fresco/images/stroke_width.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>
#include <fresco/random.h>
#include <fresco/texturing/texel_faces.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <optional>

using namespace fresco;
using evaluation::mean;

namespace
{

constexpr int swatch_side = 64;  // Samples.
/// Maximum number of swatches to cut.
constexpr std::size_t most_swatches = 1000;

constexpr std::size_t most_tries = 20 * most_swatches;
constexpr std::size_t tries_together = 500;
constexpr int most_per_sample = 8;     // Lookups along a sample's side.
constexpr int fitted = 8;              // Texels to either side of the middle, at most, that a plane is fitted to.
constexpr double unevenness = 0.05;    // Of the side.
constexpr double fitted_share = 0.75;  // Of the texels around that must be the chart's.
constexpr std::size_t pixels_per_piece = 65536;
constexpr std::size_t swatches_per_piece = 8;

/// A square cut out of a surface or of a picture, seen straight on.
struct Swatch
{
    RasterF light;   ///< L*, each sample the mean of its own area.
    Vec3f color;     ///< L*a*b*, the mean of points all over it.
    Vec2f texcoord;  ///< Texcoord of its middle on the surface.
    Vec3f point;     ///< The same in meters.
};

Vec3f lab_at(const Raster8& rgb, std::size_t pixel)
{
    const auto value = [&](std::size_t c) { return static_cast<float>(rgb.values[3 * pixel + c]) / 255; };
    return lab_from_rgb({value(0), value(1), value(2)});
}

RasterF light_of(const Raster8& rgb, const Progress& progress)
{
    RasterF light(rgb.width, rgb.height);
    parallel_items(light.values.size(), pixels_per_piece, progress, [&](std::size_t i) { light.values[i] = lab_at(rgb, i).x; });
    return light;
}

/// One pixel's step along a swatch's two sides, in pixels of what it is cut out of.
struct Axes
{
    Vec2d right, down;
};

/// Samples around `middle`, `steps` apart. \pre All of it lies in the picture.
RasterF cut(const RasterF& light, Vec2d middle, const Axes& steps)
{
    constexpr int count = swatch_side;
    const double longest = std::max(length(steps.right), length(steps.down));
    const int lookups = std::clamp(static_cast<int>(std::ceil(longest)), 1, most_per_sample);
    const auto at = [&](double x, double y)
    {
        return numerics::bilinear(numerics::between<double>(std::min(x - 0.5, light.width - 1.001), light.width),
                                  numerics::between<double>(std::min(y - 0.5, light.height - 1.001), light.height),
                                  [&](int i, int j) { return double{light.at(i, j)}; });
    };
    RasterF result(count, count);
    for (int y = 0; y < count; ++y)
        for (int x = 0; x < count; ++x)
        {
            double sum = 0;
            for (int j = 0; j < lookups; ++j)
                for (int i = 0; i < lookups; ++i)
                {
                    const double across = x + (i + 0.5) / lookups - count / 2.0;
                    const double along = y + (j + 0.5) / lookups - count / 2.0;
                    const Vec2d p = middle + steps.right * across + steps.down * along;
                    sum += at(p.x, p.y);
                }
            result.at(x, y) = static_cast<float>(sum / (lookups * lookups));
        }
    return result;
}

/// L*a*b*, the mean of single pixels all over the square that `cut` takes.
Vec3f mean_color(const Raster8& rgb, Vec2d middle, const Axes& steps)
{
    constexpr int points = 8;  // Along a side.
    Vec3f sum;
    for (int j = 0; j < points; ++j)
        for (int i = 0; i < points; ++i)
        {
            const auto samples = [](int at) { return ((at + 0.5) / points - 0.5) * swatch_side; };
            const Vec2d p = middle + steps.right * samples(i) + steps.down * samples(j);
            const auto pixel = [](double at, int size) { return static_cast<std::size_t>(std::clamp(at, 0.0, size - 1.0)); };
            sum += lab_at(rgb, pixel(p.y, rgb.height) * static_cast<std::size_t>(rgb.width) + pixel(p.x, rgb.width));
        }
    return sum * (1.0F / (points * points));
}

/// Cuts squares of `side_m` all over the flat parts of a textured mesh: on one chart whose points lie, on average, within a
/// twentieth of the side of a plane. Lengths are measured on the surface, however the atlas stretches it; the rotation is
/// arbitrary. `picture`: square RGB. The mesh must have passed check_mesh and have texcoords. The same for any number of threads.
/// Throws Canceled.
class SurfaceCutter
{
  public:
    SurfaceCutter(const Mesh& mesh, const Raster8& picture, double side_m, const Progress& progress)
        : mesh_(mesh), picture_(picture), side_m_(side_m), charts_(texturing::find_charts(mesh)),
          faces_(texturing::find_texel_faces(mesh, charts_, picture.width, progress)), light_(light_of(picture, progress))
    {
        double area = 0;
        double uv_area = 0;
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        {
            const Triangle& t = mesh.triangles[f];
            const Vec2f* uv = &mesh.texcoords[3 * f];
            area +=
                double{length(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]))};
            uv_area += std::abs(double{cross(uv[1] - uv[0], uv[2] - uv[0])});
        }
        texel_m_ = uv_area > 0 ? std::sqrt(area / uv_area) / picture.width : 0;
        for (std::size_t texel = 0; texel < faces_.inside.size(); ++texel)
            if (faces_.inside[texel] != 0)
                texels_.push_back(static_cast<std::uint32_t>(texel));
    }

    std::vector<Swatch> cut_all(const Progress& progress) const
    {
        std::vector<Swatch> result;
        if (texels_.empty() || texel_m_ <= 0)
            return result;
        Random random(1);
        std::vector<std::uint32_t> tries(most_tries);
        for (std::uint32_t& texel : tries)
            texel = texels_[static_cast<std::size_t>(random.below(static_cast<std::int64_t>(texels_.size())))];
        std::vector<std::optional<Swatch>> found(tries_together);
        for (std::size_t first = 0; first < tries.size() && result.size() < most_swatches; first += tries_together)
        {
            parallel_items(tries_together, swatches_per_piece, progress,
                           [&](std::size_t i) { found[i] = cut_at(tries[first + i]); });
            for (std::optional<Swatch>& swatch : found)
                if (swatch && result.size() < most_swatches)
                    result.push_back(std::move(*swatch));
        }
        return result;
    }

  private:
    std::uint32_t chart_at(int x, int y) const
    {
        if (x < 0 || y < 0 || x >= faces_.size || y >= faces_.size)
            return TexelFaces::none;
        const std::size_t texel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(faces_.size) + static_cast<std::size_t>(x);
        return faces_.inside[texel] != 0 ? charts_.of_face[faces_.face[texel]] : TexelFaces::none;
    }

    /// How the surface runs around a texel: fitted to the points of its chart within reach, nothing unless they are even.
    std::optional<Axes> steps_at(int x, int y) const
    {
        const std::uint32_t chart = chart_at(x, y);
        const int radius = std::max(1, static_cast<int>(std::ceil(0.71 * side_m_ / texel_m_)));
        const int stride = std::max(1, radius / fitted);
        std::vector<Vec2d> places;
        std::vector<Vec3d> points;
        int all = 0;
        for (int j = -radius; j <= radius; j += stride)
            for (int i = -radius; i <= radius; i += stride)
            {
                if (i * i + j * j > radius * radius)
                    continue;
                ++all;
                if (chart_at(x + i, y + j) != chart)
                    continue;
                const std::size_t texel =
                    static_cast<std::size_t>(y + j) * static_cast<std::size_t>(faces_.size) + static_cast<std::size_t>(x + i);
                places.push_back({double(i), double(j)});
                points.push_back(vec_cast<double>(texturing::texel_position(mesh_, faces_, texel)));
            }
        if (static_cast<double>(places.size()) < fitted_share * all || places.size() < 3)
            return std::nullopt;
        return fitted_steps(places, points);
    }

    std::optional<Axes> fitted_steps(std::vector<Vec2d>& places, std::vector<Vec3d>& points) const
    {
        const double share = 1 / static_cast<double>(places.size());
        Vec2d place;
        Vec3d point;
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            place = place + places[i] * share;
            point += points[i] * share;
        }
        double xx = 0, xy = 0, yy = 0;
        Vec3d px, py;
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            places[i] = places[i] - place;
            points[i] = points[i] - point;
            xx += places[i].x * places[i].x;
            xy += places[i].x * places[i].y;
            yy += places[i].y * places[i].y;
            px += points[i] * places[i].x;
            py += points[i] * places[i].y;
        }
        const double determinant = xx * yy - xy * xy;
        if (determinant <= 0)
            return std::nullopt;
        const Vec3d along_x = (px * yy - py * xy) * (1 / determinant);
        const Vec3d along_y = (py * xx - px * xy) * (1 / determinant);
        double off = 0;
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            const Vec3d rest = points[i] - along_x * places[i].x - along_y * places[i].y;
            off += dot(rest, rest) * share;
        }
        if (std::sqrt(off) > unevenness * side_m_)
            return std::nullopt;
        // The inverse of (along_x, along_y) in an orthonormal basis of their plane.
        const double stretch = length(along_x);
        if (stretch <= 0)
            return std::nullopt;
        const double shear = dot(along_x, along_y) / stretch;
        const double rest = std::sqrt(std::max(dot(along_y, along_y) - shear * shear, 0.0));
        if (rest <= 0)
            return std::nullopt;
        const double step = side_m_ / swatch_side;
        return Axes{Vec2d{step / stretch, 0}, Vec2d{-shear / stretch * step / rest, step / rest}};
    }

    std::optional<Swatch> cut_at(std::uint32_t texel) const
    {
        const auto size = static_cast<std::uint32_t>(faces_.size);
        const int x = static_cast<int>(texel % size);
        const int y = static_cast<int>(texel / size);
        const std::optional<Axes> steps = steps_at(x, y);
        if (!steps)
            return std::nullopt;
        const std::uint32_t chart = chart_at(x, y);
        const Vec2d middle{x + 0.5, y + 0.5};
        constexpr int half = swatch_side / 2;
        for (int j = -half; j <= half; ++j)
            for (int i = -half; i <= half; ++i)
            {
                const Vec2d p = middle + steps->right * i + steps->down * j;
                if (chart_at(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y))) != chart)
                    return std::nullopt;
            }
        return Swatch{cut(light_, middle, *steps),
                      mean_color(picture_, middle, *steps),
                      {static_cast<float>(middle.x / faces_.size), static_cast<float>(1 - middle.y / faces_.size)},
                      texturing::texel_position(mesh_, faces_, texel)};
    }

    using TexelFaces = texturing::TexelFaces;

    const Mesh& mesh_;
    const Raster8& picture_;
    double side_m_;
    double texel_m_ = 0;
    texturing::Charts charts_;
    TexelFaces faces_;
    RasterF light_;
    std::vector<std::uint32_t> texels_;
};

/// Squares of `side_px` all over a picture; none if it is smaller.
std::vector<Swatch> picture_swatches(const Raster8& rgb, double side_px, const Progress& progress)
{
    if (rgb.width < side_px || rgb.height < side_px)
        return {};
    const RasterF light = light_of(rgb, progress);
    Random random(1);
    std::vector<Vec2d> middles(most_swatches);
    for (Vec2d& middle : middles)
    {
        middle.x = side_px / 2 + random.uniform() * (rgb.width - side_px);
        middle.y = side_px / 2 + random.uniform() * (rgb.height - side_px);
    }
    const double step = side_px / swatch_side;
    const Axes steps{{step, 0}, {0, step}};
    std::vector<Swatch> result(most_swatches);
    parallel_items(most_swatches, swatches_per_piece, progress,
                   [&](std::size_t i) {
                       result[i] = {cut(light, middles[i], steps), mean_color(rgb, middles[i], steps), {}, {}};
                   });
    return result;
}

constexpr std::size_t least_places = 4;
constexpr double similar_color = 6;  // Sigma, CIE76.
/// Sigma, in sides, of how the common part of two squares' energies falls with their distance: the autocorrelation of the square
/// of their Hann window is nearly a Gaussian.
constexpr double shared_spread = 0.2;

/// Of the picture's squares, weighted by how similar their colors are.
double size_of_color(Vec3f color, const std::vector<ColoredSize>& picture)
{
    double sum = 0;
    double total = 0;
    for (const ColoredSize& square : picture)
    {
        const Vec3d apart = vec_cast<double>(square.color - color);
        // Far from all colors it is the picture's mean.
        const double weight = 1e-9 + std::exp(-dot(apart, apart) / (2 * similar_color * similar_color));
        sum += weight * square.size;
        total += weight;
    }
    return sum / total;
}

double product(const std::vector<double>& x, const std::vector<double>& y)
{
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        sum += x[i] * y[i];
    return sum;
}

std::vector<double> centered(std::vector<double> values)
{
    const double middle = mean(values);
    for (double& value : values)
        value -= middle;
    return values;
}

/// What is left of `values` when they are predicted from `control` by a straight line. \pre Both are centered.
std::vector<double> without(std::vector<double> values, const std::vector<double>& control)
{
    const double square = product(control, control);
    const double slope = square > 0 ? product(values, control) / square : 0;
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] -= slope * control[i];
    return values;
}

/// Variance of the correlation of two independent fields with the autocorrelations of `x` and `y`. \pre Both are centered.
/// Autocorrelations of few places are estimated too low, because their means are subtracted. So no more places count as
/// independent than the squares that do not overlap.
double chance_variance(const std::vector<PlacedSize>& places, const std::vector<double>& x, const std::vector<double>& y,
                       double side_m)
{
    struct Class
    {
        double x = 0, y = 0, pairs = 0;
    };
    std::vector<Class> classes;
    const auto count = static_cast<double>(places.size());
    double overlap = count;
    for (std::size_t i = 0; i < places.size(); ++i)
        for (std::size_t j = i + 1; j < places.size(); ++j)
        {
            const double apart = double{length(places[i].point - places[j].point)} / side_m;
            const auto index = static_cast<std::size_t>(4 * std::log2(1 + 2 * apart));
            if (index >= classes.size())
                classes.resize(index + 1);
            classes[index].x += 2 * x[i] * x[j];
            classes[index].y += 2 * y[i] * y[j];
            classes[index].pairs += 2;
            overlap += 2 * std::exp(-apart * apart / (2 * shared_spread * shared_spread));
        }
    // A place with itself is a class of its own, where both autocorrelations are 1.
    double sum = product(x, x) * product(y, y) / count;
    for (const Class& one : classes)
        if (one.pairs > 0)
            sum += one.x * one.y / one.pairs;
    return std::max(sum / (product(x, x) * product(y, y)), overlap / (count * count));
}

}  // namespace

SizeByDistance size_by_distance(const std::vector<PlacedSize>& places, const std::vector<ColoredSize>& picture, double side_m)
{
    SizeByDistance result;
    result.places = places.size();
    if (places.size() < least_places)
        return result;
    std::vector<double> sizes;
    std::vector<double> distances;
    std::vector<double> expected;
    for (const PlacedSize& place : places)
    {
        sizes.push_back(place.strokes.size);
        distances.push_back(place.distance);
        expected.push_back(size_of_color(place.strokes.color, picture));
    }
    expected = centered(std::move(expected));
    sizes = without(centered(std::move(sizes)), expected);
    distances = without(centered(std::move(distances)), expected);
    result.correlation = evaluation::pearson(sizes, distances);
    // Sizes that do depend on distance are as alike as distances; the rest says how far chance goes.
    const std::vector<double> rest = without(sizes, distances);
    if (!std::isnan(result.correlation))
        result.standard_error = std::sqrt(chance_variance(places, rest, distances, side_m));
    return result;
}

namespace
{

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
    static const std::array<double, swatch_side> window = []
    {
        std::array<double, swatch_side> hann{};
        for (std::size_t i = 0; i < swatch_side; ++i)
            hann[i] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i + 1) / (swatch_side + 1));
        return hann;
    }();
    std::array<Line, swatch_side> result;
    for (std::size_t y = 0; y < swatch_side; ++y)
        for (std::size_t x = 0; x < swatch_side; ++x)
            result[y][x] = (double{light.at(static_cast<int>(x), static_cast<int>(y))} - mean -
                            across * offset(static_cast<int>(x)) - along * offset(static_cast<int>(y))) *
                           window[x] * window[y];
    return result;
}

/// What becomes of one frequency of a transformed swatch.
struct SpectrumTerm
{
    std::size_t bin = 0;  ///< Of the spectrum.
    double kept = 0;      ///< Share of its amplitude between `finest_sigma` and `broadest_sigma`.
};

/// For each frequency of a transformed swatch, row by row.
const std::vector<SpectrumTerm>& spectrum_terms()
{
    static const std::vector<SpectrumTerm> values = []
    {
        std::vector<SpectrumTerm> table;
        const auto cycles = [](int i) { return i <= swatch_side / 2 ? i : i - swatch_side; };
        for (int y = 0; y < swatch_side; ++y)
            for (int x = 0; x < swatch_side; ++x)
            {
                const double frequency = std::hypot(cycles(x), cycles(y));
                const double square =
                    2 * std::numbers::pi * std::numbers::pi * frequency * frequency / (swatch_side * swatch_side);
                table.push_back({static_cast<std::size_t>(std::lround(frequency * bins_per_cycle)),
                                 (1 - std::exp(-square * broadest_sigma * broadest_sigma)) *
                                     std::exp(-square * finest_sigma * finest_sigma)});
            }
        return table;
    }();
    return values;
}

/// Energy of the detail that `spectrum_terms` keeps, from all directions.
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
            const SpectrumTerm& term = spectrum_terms()[y * swatch_side + x];
            result[term.bin] += std::norm(column[y]) * term.kept * term.kept;
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

std::vector<Spectrum> spectra_of(const std::vector<Swatch>& swatches, const Progress& progress)
{
    std::vector<Spectrum> result(swatches.size());
    parallel_items(swatches.size(), swatches_per_piece, progress,
                   [&](std::size_t i) { result[i] = spectrum_of(swatches[i].light); });
    return result;
}

/// Mean distance from the cameras for each cell of a square grid over the texture, in meters along their axes, row by row from
/// the lower left; 0 for cells that no camera saw. Throws Error for maps that cannot be read, Canceled.
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

}  // namespace

StrokeSize stroke_size(const TexturedMesh& painting, const Raster8& style, double stroke_cm, const UvMaps* uvmaps,
                       const Progress& progress)
{
    const std::vector<Swatch> in_picture = picture_swatches(style, strokes_per_side * stroke_width_px(style, progress), progress);
    const std::vector<Spectrum> picture_spectra = spectra_of(in_picture, progress);
    const double picture_width = half_width(sum_of(picture_spectra));
    if (std::isnan(picture_width))
        throw Error(fmt::format("the picture on port 'style' is {} x {}: smaller than {:g} of its strokes, or of one color, so "
                                "that there is no size to compare with; use a larger one",
                                style.width, style.height, strokes_per_side));
    const double side_m = strokes_per_side * stroke_cm / 100;
    const std::vector<Swatch> swatches = SurfaceCutter(painting.mesh, painting.image.pixels, side_m, progress).cut_all(progress);
    const std::vector<Spectrum> spectra = spectra_of(swatches, progress);
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

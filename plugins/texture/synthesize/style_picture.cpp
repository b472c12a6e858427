#include "style_picture.h"

#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/images/lab.h>
#include <fresco/math.h>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace fresco::synthesize
{

Vec3f mean_color(const float* values, std::size_t count)
{
    Vec3f sum;
    for (std::size_t v = 0; v < count; v += 3)
        sum += Vec3f{values[v], values[v + 1], values[v + 2]};
    return sum * (3 / static_cast<float>(count));
}

namespace
{

constexpr double least_key_step = 2;
constexpr std::size_t picture_rows_per_piece = 64;
constexpr double least_variance = 1e-6;  // L*a*b*: of a picture that has any contrast.

constexpr double direction_sigma = 0.5;  // In widths of a stroke: directions are averaged over a Gaussian.

int count_along(int pixels, int border, double step)
{
    return 1 + static_cast<int>((pixels - 2 * border - 1) / step);
}

bool has_contrast(const RasterF& lab)
{
    Vec3d sum;
    Vec3d squares;
    for (std::size_t i = 0; i < lab.values.size(); i += 3)
    {
        const Vec3d v{double{lab.values[i]}, double{lab.values[i + 1]}, double{lab.values[i + 2]}};
        sum += v;
        squares += {v.x * v.x, v.y * v.y, v.z * v.z};
    }
    const double count = static_cast<double>(lab.values.size()) / 3;
    return (squares.x + squares.y + squares.z) / count - dot(sum, sum) / (count * count) > least_variance;
}

/// Subtracts from each patch the part of its mean color that makes squared differences match squared_gap.
void fade_means(std::vector<float>& patches, std::size_t values_per_patch)
{
    const float taken = 1 - std::sqrt(1 - shift_share);
    for (std::size_t first = 0; first < patches.size(); first += values_per_patch)
    {
        const Vec3f away = mean_color(&patches[first], values_per_patch) * taken;
        for (std::size_t v = first; v < first + values_per_patch; v += 3)
        {
            patches[v] -= away.x;
            patches[v + 1] -= away.y;
            patches[v + 2] -= away.z;
        }
    }
}

}  // namespace

StylePicture::StylePicture(const Raster8& rgb, double scale, int side, const Progress& progress, double stroke_px,
                           const Raster8& opaque)
    : scale_(scale), side_(side), border_(stroke_px > 0 ? static_cast<int>(std::ceil(side / 2 * std::numbers::sqrt2)) : side / 2)
{
    const int width = std::max(1, static_cast<int>(std::lround(rgb.width * scale)));
    const int height = std::max(1, static_cast<int>(std::lround(rgb.height * scale)));
    if (const int least = 2 * border_ + 1; width < least || height < least)
        throw Error(fmt::format("the style picture is {}x{} pixels, {}x{} at the scale of the search: smaller than one patch of "
                                "{} pixels; use a larger picture",
                                rgb.width, rgb.height, width, height, least));
    lab_ = lab_picture(resized(rgb, width, height));
    if (!has_contrast(lab_))
        throw Error("the style picture has a single color: use a picture with brush strokes or other patterns");
    steps_ = Raster<std::int16_t>(width, height, 3);
    std::ranges::transform(lab_.values, steps_.values.begin(), in_steps);
    colors_ = ColorLookup<float>(lab_);
    if (stroke_px > 0)
        find_directions(stroke_px);
    else
        find_means(progress);
    key_step_ = least_key_step;
    while (static_cast<std::size_t>(count_along(width, border_, key_step_)) *
               static_cast<std::size_t>(count_along(height, border_, key_step_)) >
           most_keys)
        key_step_ += 0.125;
    columns_ = count_along(width, border_, key_step_);
    rows_ = count_along(height, border_, key_step_);
    column_near_ = nearest_along(width, columns_);
    row_near_ = nearest_along(height, rows_);
    if (!opaque.empty())
        find_opaque_keys(resized(opaque, width, height));
    make_basis(progress);
}

void StylePicture::find_opaque_keys(const Raster8& opaque)
{
    opaque_sums_ = Raster<std::uint32_t>(opaque.width + 1, opaque.height + 1);
    for (int y = 1; y <= opaque.height; ++y)
        for (int x = 1; x <= opaque.width; ++x)
            opaque_sums_.at(x, y) = (opaque.at(x - 1, y - 1) == 255 ? 1U : 0U) + opaque_sums_.at(x - 1, y) +
                                    opaque_sums_.at(x, y - 1) - opaque_sums_.at(x - 1, y - 1);
    for (std::uint32_t place = 0; place < grid_count(); ++place)
        if (has_patch(grid_place(place)))
            opaque_keys_.push_back(place);
    if (opaque_keys_.empty())
        throw Error(fmt::format("no opaque part of the style picture is as large as one patch of {} pixels, at {}x{} pixels, the "
                                "scale of the search; use a picture with less transparency, or a larger one",
                                2 * border_ + 1, opaque.width, opaque.height));
    nearest_key_.resize(grid_count());
    for (std::size_t place = 0; place < nearest_key_.size(); ++place)
    {
        const auto away = [&](std::uint32_t key) { return length(grid_place(key) - grid_place(place)); };
        nearest_key_[place] = static_cast<std::uint32_t>(std::ranges::min_element(opaque_keys_, {}, away) - opaque_keys_.begin());
    }
}

double StylePicture::opaque_count(int x0, int y0, int x1, int y1) const
{
    if (opaque_sums_.empty())
        return static_cast<double>(x1 - x0) * (y1 - y0);
    const auto& sums = opaque_sums_;
    return static_cast<double>(sums.at(x1, y1) + sums.at(x0, y0) - sums.at(x0, y1) - sums.at(x1, y0));
}

bool StylePicture::has_patch(Vec2f at) const
{
    if (opaque_sums_.empty())
        return true;
    // A place between pixels looks up the next one, too.
    const int reach = border_ + 1;
    const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y));
    const int x0 = std::max(0, x - reach), y0 = std::max(0, y - reach);
    const int x1 = std::min(lab_.width, x + reach + 1), y1 = std::min(lab_.height, y + reach + 1);
    return opaque_count(x0, y0, x1, y1) == static_cast<double>(x1 - x0) * (y1 - y0);
}

void StylePicture::find_means(const Progress& progress)
{
    means_ = RasterF(lab_.width, lab_.height, 3);
    const int half = side_ / 2;
    const auto rows = static_cast<std::size_t>(lab_.height - 2 * half);
    parallel_for(rows, picture_rows_per_piece, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<Vec3f> columns(static_cast<std::size_t>(lab_.width));  // Sums of a patch's height.
                     for (int y = half + static_cast<int>(begin); y < half + static_cast<int>(end); ++y)
                     {
                         std::ranges::fill(columns, Vec3f{});
                         for (int row = y - half; row <= y + half; ++row)
                             for (int x = 0; x < lab_.width; ++x)
                                 columns[static_cast<std::size_t>(x)] += mean_color(&lab_.at(x, row), 3);
                         for (int x = half; x < lab_.width - half; ++x)
                         {
                             const auto first = static_cast<std::size_t>(x - half);
                             const Vec3f mean = mean_color(&columns[first].x, 3 * static_cast<std::size_t>(side_)) *
                                                (1 / static_cast<float>(side_));
                             std::ranges::copy(std::array{mean.x, mean.y, mean.z}, &means_.at(x, y));
                         }
                     }
                 });
}

void StylePicture::make_basis(const Progress& progress)
{
    const std::size_t count = key_count();
    const std::size_t values = values_per_patch();
    const std::size_t row_values = 3 * static_cast<std::size_t>(side_);
    const std::size_t picture_row = 3 * static_cast<std::size_t>(lab_.width);
    std::vector<float> patches(count * values);
    for (std::size_t i = 0; i < count; ++i)
    {
        const Vec2f at = key(i);
        float* out = &patches[i * values];
        if (is_directed())
            turned_patch(at, direction(at), out);
        else
        {
            const float* row = &lab_.at(static_cast<int>(at.x) - side_ / 2, static_cast<int>(at.y) - side_ / 2);
            for (int y = 0; y < side_; ++y, row += picture_row, out += row_values)
                std::copy(row, row + row_values, out);
        }
    }
    std::vector<float> centered = patches;
    fade_means(centered, values);
    std::vector<double> sum(values, 0.0);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t v = 0; v < values; ++v)
            sum[v] += static_cast<double>(centered[i * values + v]);
    mean_.resize(values);
    for (std::size_t v = 0; v < values; ++v)
        mean_[v] = static_cast<float>(sum[v] / static_cast<double>(count));
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t v = 0; v < values; ++v)
            centered[i * values + v] -= mean_[v];
    std::vector<float> products(values * values);
    const auto stride = static_cast<std::ptrdiff_t>(values);
    multiply_matrices({centered.data(), values, count, 1, stride}, {centered.data(), count, values, stride, 1}, products.data(),
                      progress.threads());
    Eigen::MatrixXd covariance(values, values);
    for (std::size_t i = 0; i < values; ++i)
        for (std::size_t j = 0; j < values; ++j)
            covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
                (static_cast<double>(products[i * values + j]) + static_cast<double>(products[j * values + i])) /
                (2 * static_cast<double>(count));
    progress.check_canceled();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
    const auto last = static_cast<Eigen::Index>(values) - 1;
    features_ = std::min(values, most_features);
    basis_.resize(values * features_);
    for (std::size_t f = 0; f < features_; ++f)
        for (std::size_t v = 0; v < values; ++v)
            basis_[v * features_ + f] =
                static_cast<float>(solver.eigenvectors()(static_cast<Eigen::Index>(v), last - static_cast<Eigen::Index>(f)));
    key_features_.resize(count * features_);
    project(patches.data(), count, key_features_.data());
}

Vec2f StylePicture::key(std::size_t number) const
{
    return grid_place(opaque_keys_.empty() ? number : opaque_keys_[number]);
}

Vec2f StylePicture::grid_place(std::size_t number) const
{
    const std::size_t column = number % static_cast<std::size_t>(columns_);
    const std::size_t row = number / static_cast<std::size_t>(columns_);
    return {static_cast<float>(border_ + std::lround(static_cast<double>(column) * key_step_)),
            static_cast<float>(border_ + std::lround(static_cast<double>(row) * key_step_))};
}

std::vector<std::uint32_t> StylePicture::nearest_along(int pixels, int count) const
{
    std::vector<std::uint32_t> result(2 * static_cast<std::size_t>(pixels));
    std::uint32_t nearest = 0;
    const auto away = [&](std::uint32_t index, std::size_t half)
    { return std::abs(static_cast<double>(border_ + std::lround(index * key_step_)) - (static_cast<double>(half) + 0.5) / 2); };
    for (std::size_t half = 0; half < result.size(); ++half)
    {
        while (nearest + 1 < static_cast<std::uint32_t>(count) && away(nearest + 1, half) < away(nearest, half))
            ++nearest;
        result[half] = nearest;
    }
    return result;
}

std::size_t StylePicture::key_near(Vec2f at) const
{
    // Keys are at whole pixels: the nearest one is the same for all places within half a pixel.
    const auto near = [](float along, const std::vector<std::uint32_t>& nearest)
    { return nearest[std::min(static_cast<std::size_t>(std::max(0.0F, 2 * along)), nearest.size() - 1)]; };
    const std::size_t place = std::size_t{near(at.y, row_near_)} * static_cast<std::size_t>(columns_) + near(at.x, column_near_);
    return nearest_key_.empty() ? place : nearest_key_[place];
}

int StylePicture::key_reach() const
{
    return static_cast<int>(std::ceil(key_step_ / 2));
}

void StylePicture::project(const float* patches, std::size_t rows, float* features) const
{
    const std::size_t values = values_per_patch();
    std::vector<float> centered(patches, patches + rows * values);
    fade_means(centered, values);
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t v = 0; v < values; ++v)
            centered[row * values + v] -= mean_[v];
    const auto stride = static_cast<std::ptrdiff_t>(values);
    multiply_matrices({centered.data(), rows, values, stride, 1},
                      {basis_.data(), values, features_, static_cast<std::ptrdiff_t>(features_), 1}, features, 1);
}

Vec2f StylePicture::inside(Vec2f at) const
{
    const auto half = static_cast<float>(border_);
    return {std::clamp(at.x, half, static_cast<float>(lab_.width - 1) - half),
            std::clamp(at.y, half, static_cast<float>(lab_.height - 1) - half)};
}

void StylePicture::find_directions(double stroke_px)
{
    const Gradient slope = sobel(blurred(channel(lab_, 0), 1));
    RasterF products(lab_.width, lab_.height, 3);
    for (std::size_t i = 0; i < slope.x.values.size(); ++i)
    {
        const float x = slope.x.values[i];
        const float y = slope.y.values[i];
        products.values[3 * i] = y * y - x * x;
        products.values[3 * i + 1] = -2 * x * y;
        products.values[3 * i + 2] = x * x + y * y;
    }
    const RasterF means = blurred(products, std::max(1.0, direction_sigma * stroke_px));
    directions_ = RasterF(lab_.width, lab_.height, 2);
    for (std::size_t i = 0; i < slope.x.values.size(); ++i)
        for (std::size_t c = 0; c < 2; ++c)
            directions_.values[2 * i + c] = means.values[3 * i + c] / std::max(means.values[3 * i + 2], 1e-6F);
}

Vec2f StylePicture::direction(Vec2f at) const
{
    const float* twice = twice_angle(at);
    const float angle = std::atan2(twice[1], twice[0]) / 2;
    return {std::cos(angle), std::sin(angle)};
}

float StylePicture::misalignment(Vec2f at, Vec2f turn) const
{
    const float* twice = twice_angle(at);
    const float in_line = twice[0] * (turn.x * turn.x - turn.y * turn.y) + twice[1] * 2 * turn.x * turn.y;
    return (std::hypot(twice[0], twice[1]) - in_line) / 2;
}

void StylePicture::turned_patch(Vec2f at, Vec2f turn, float* values) const
{
    const auto half = static_cast<float>(side_ / 2);
    for (int j = 0; j < side_; ++j)
        for (int i = 0; i < side_; ++i, values += 3)
        {
            const Vec3f own = color(at + turned({static_cast<float>(i) - half, static_cast<float>(j) - half}, turn));
            std::ranges::copy(std::array{own.x, own.y, own.z}, values);
        }
}

}  // namespace fresco::synthesize

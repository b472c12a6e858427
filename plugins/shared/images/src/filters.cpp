#include <fresco/images/filters.h>
#include <fresco/numerics/bilinear.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace fresco
{

namespace
{
/// An index beyond [0, size), mirrored at the first and last.
int mirrored(int i, int size)
{
    if (size == 1)
        return 0;
    while (i < 0 || i >= size)
        i = i < 0 ? -i : 2 * (size - 1) - i;
    return i;
}

/// Weights at -radius … radius.
std::vector<float> gaussian(double sigma)
{
    // An odd number of weights next to 8 sigma, as OpenCV takes it for floating point.
    const int count = static_cast<int>(std::lround(8 * sigma + 1)) | 1;
    std::vector<double> weights;
    double sum = 0;
    for (int i = 0; i < count; ++i)
    {
        const double at = i - (count - 1) / 2.0;
        weights.push_back(std::exp(-at * at / (2 * sigma * sigma)));
        sum += weights.back();
    }
    std::vector<float> result(weights.size());
    std::ranges::transform(weights, result.begin(), [&](double weight) { return static_cast<float>(weight / sum); });
    return result;
}

/// Adds `weight` times `count` values.
void add(float* to, const float* from, float weight, std::size_t count)
{
    for (std::size_t i = 0; i < count; ++i)
        to[i] += weight * from[i];
}

RasterF along_x(const RasterF& picture, const std::vector<float>& kernel)
{
    const int radius = static_cast<int>(kernel.size() / 2);
    const auto channels = static_cast<std::size_t>(picture.channels);
    const std::size_t row_values = static_cast<std::size_t>(picture.width) * channels;
    std::vector<float> padded(row_values + 2 * static_cast<std::size_t>(radius) * channels);
    RasterF result(picture.width, picture.height, picture.channels);
    for (int y = 0; y < picture.height; ++y)
    {
        for (int x = -radius; x < picture.width + radius; ++x)
            std::copy_n(&picture.values[picture.index(mirrored(x, picture.width), y)], channels,
                        &padded[static_cast<std::size_t>(x + radius) * channels]);
        for (std::size_t k = 0; k < kernel.size(); ++k)
            add(&result.at(0, y), &padded[k * channels], kernel[k], row_values);
    }
    return result;
}

RasterF along_y(const RasterF& picture, const std::vector<float>& kernel)
{
    const int radius = static_cast<int>(kernel.size() / 2);
    const std::size_t row_values = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.channels);
    RasterF result(picture.width, picture.height, picture.channels);
    for (int y = 0; y < picture.height; ++y)
    {
        int from = y - radius;
        for (const float weight : kernel)
            add(&result.at(0, y), &picture.at(0, mirrored(from++, picture.height)), weight, row_values);
    }
    return result;
}
}  // namespace

RasterF blurred(const RasterF& picture, double sigma_px)
{
    const std::vector<float> kernel = gaussian(sigma_px);
    return along_y(along_x(picture, kernel), kernel);
}

RasterF local_variance(const RasterF& picture, double sigma_px)
{
    const auto channels = static_cast<std::size_t>(picture.channels);
    RasterF squares(picture.width, picture.height);
    for (std::size_t i = 0; i < picture.values.size(); ++i)
        squares.values[i / channels] += picture.values[i] * picture.values[i];
    const RasterF mean = blurred(picture, sigma_px);
    RasterF result = blurred(squares, sigma_px);
    for (std::size_t i = 0; i < mean.values.size(); ++i)
        result.values[i / channels] -= mean.values[i] * mean.values[i];
    for (float& v : result.values)
        v = std::max(v, 0.0F);
    return result;
}

Gradient sobel(const RasterF& plane)
{
    const std::vector<float> slope{-1, 0, 1};
    const std::vector<float> smooth{1, 2, 1};
    return {along_y(along_x(plane, slope), smooth), along_y(along_x(plane, smooth), slope)};
}

Raster8 on_gray(const Raster8& rgba, int level)
{
    Raster8 rgb(rgba.width, rgba.height, 3);
    const std::uint8_t* from = rgba.values.data();
    for (std::uint8_t* to = rgb.values.data(); to != rgb.values.data() + rgb.values.size(); to += 3, from += 4)
        for (int c = 0; c < 3; ++c)
            to[c] =
                from[3] == 255 ? from[c] : static_cast<std::uint8_t>((from[c] * from[3] + level * (255 - from[3]) + 127) / 255);
    return rgb;
}

RasterF channel(const RasterF& picture, int index)
{
    RasterF result(picture.width, picture.height);
    for (std::size_t i = 0; i < result.values.size(); ++i)
        result.values[i] = picture.values[i * static_cast<std::size_t>(picture.channels) + static_cast<std::size_t>(index)];
    return result;
}

namespace
{

struct Level
{
    RasterF picture;
    Raster8 covered;
};

/// Means over the covered ones of 2 x 2 texels.
Level halved(const RasterF& picture, const Raster8& covered)
{
    Level half{RasterF((picture.width + 1) / 2, (picture.height + 1) / 2, picture.channels),
               Raster8((picture.width + 1) / 2, (picture.height + 1) / 2)};
    for (int y = 0; y < half.covered.height; ++y)
        for (int x = 0; x < half.covered.width; ++x)
        {
            float count = 0;
            for (int v = 2 * y; v < std::min(2 * y + 2, picture.height); ++v)
                for (int u = 2 * x; u < std::min(2 * x + 2, picture.width); ++u)
                    if (covered.at(u, v) != 0)
                    {
                        ++count;
                        for (int c = 0; c < picture.channels; ++c)
                            half.picture.at(x, y, c) += picture.at(u, v, c);
                    }
            if (count == 0)
                continue;
            half.covered.at(x, y) = 1;
            for (int c = 0; c < picture.channels; ++c)
                half.picture.at(x, y, c) /= count;
        }
    return half;
}

/// The full `coarse` looked up bilinearly where `fine` is not covered.
void fill(RasterF& fine, const Raster8& covered, const RasterF& coarse)
{
    for (int y = 0; y < fine.height; ++y)
        for (int x = 0; x < fine.width; ++x)
        {
            if (covered.at(x, y) != 0)
                continue;
            const auto column = numerics::between<float>((static_cast<float>(x) + 0.5F) / 2 - 0.5F, coarse.width);
            const auto row = numerics::between<float>((static_cast<float>(y) + 0.5F) / 2 - 0.5F, coarse.height);
            for (int c = 0; c < fine.channels; ++c)
                fine.at(x, y, c) = numerics::bilinear(column, row, [&](int u, int v) { return coarse.at(u, v, c); });
        }
}

}  // namespace

void push_pull(RasterF& picture, const Raster8& covered)
{
    const auto is_hole = [](auto v) { return v == 0; };
    if (std::none_of(covered.values.begin(), covered.values.end(), is_hole) ||
        std::all_of(covered.values.begin(), covered.values.end(), is_hole))
        return;
    Level half = halved(picture, covered);
    push_pull(half.picture, half.covered);
    fill(picture, covered, half.picture);
}

}  // namespace fresco

#include <fresco/images/filters.h>
#include <fresco/images/lab.h>
#include <fresco/images/sharpness.h>

#include <cstdint>
#include <vector>

namespace fresco
{

namespace
{

/// Sampled as OpenCV's nearest neighbor does it, so that values measured after it, as in the released preparation of StyleMesh,
/// are met.
Raster<int> sampled_gray(const Raster8& rgb, int width, int height)
{
    const Raster8 sampled = nearest_sampled(rgb, width, height);
    Raster<int> result(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            result.at(x, y) = (fixed_luma(&sampled.at(x, y)) + (1 << 14)) >> 15;
    return result;
}

}  // namespace

double sharpness(const Raster8& rgb, int width, int height)
{
    const Raster<int> picture = sampled_gray(rgb, width, height);
    std::int64_t sum = 0;
    std::int64_t squares = 0;
    for (int y = 0; y < height; ++y)
    {
        const int above = y > 0 ? y - 1 : 1;
        const int below = y + 1 < height ? y + 1 : height - 2;
        for (int x = 0; x < width; ++x)
        {
            const int left = x > 0 ? x - 1 : 1;
            const int right = x + 1 < width ? x + 1 : width - 2;
            const std::int64_t edge =
                picture.at(left, y) + picture.at(right, y) + picture.at(x, above) + picture.at(x, below) - 4 * picture.at(x, y);
            sum += edge;
            squares += edge * edge;
        }
    }
    const double count = static_cast<double>(width) * height;
    const double mean = static_cast<double>(sum) / count;
    return static_cast<double>(squares) / count - mean * mean;
}

double usual_sharpness(const Raster8& rgb)
{
    return sharpness(rgb, 320, 240);
}

}  // namespace fresco

#include "catch.h"

#include <fresco/images/sharpness.h>
#include <fresco/testing_scenes.h>

#include <cmath>

using namespace fresco;

using testing::checkerboard;

namespace
{

/// The definition, written out: nearest sampling, gray, 4-neighbor Laplacian with borders mirrored about the edge pixel.
double slow_sharpness(const Raster8& rgb, int width, int height)
{
    const auto gray = [&](int x, int y)
    {
        x = x < 0 ? -x : x >= width ? 2 * width - 2 - x : x;
        y = y < 0 ? -y : y >= height ? 2 * height - 2 - y : y;
        const int sx = x * rgb.width / width;
        const int sy = y * rgb.height / height;
        return std::round(0.299 * rgb.at(sx, sy, 0) + 0.587 * rgb.at(sx, sy, 1) + 0.114 * rgb.at(sx, sy, 2));
    };
    double sum = 0, squares = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const double edge = gray(x - 1, y) + gray(x + 1, y) + gray(x, y - 1) + gray(x, y + 1) - 4 * gray(x, y);
            sum += edge;
            squares += edge * edge;
        }
    const double count = width * height;
    return squares / count - (sum / count) * (sum / count);
}

}  // namespace

TEST_CASE("sharpness of pictures that can be computed by hand")
{
    CHECK(sharpness(Raster8(40, 30, 3, 99), 40, 30) == 0);
    // Every pixel of a board of single pixels differs from its four neighbors by 100, up or down: the Laplacian is +-400.
    CHECK(sharpness(checkerboard(40, 30, 1, 50, 150), 40, 30) == Approx(160'000));
    // Every second pixel of it has one color: at half size nothing is left.
    CHECK(sharpness(checkerboard(40, 30, 1, 50, 150), 20, 15) == 0);
}

TEST_CASE("sharpness is the variance of the Laplacian as written out")
{
    const Raster8 picture = testing::noise_picture(61, 47, 7);
    for (const auto& [width, height] : {std::pair{61, 47}, std::pair{30, 23}})
        CHECK(sharpness(picture, width, height) == Approx(slow_sharpness(picture, width, height)).epsilon(1e-3));
}

#include "catch.h"

#include <fresco/images/lab.h>

#include <cmath>

using namespace fresco;

namespace
{
bool near(Vec3f a, Vec3f b, float margin)
{
    return std::abs(a.x - b.x) < margin && std::abs(a.y - b.y) < margin && std::abs(a.z - b.z) < margin;
}
}  // namespace

TEST_CASE("known colors in CIE L*a*b*")
{
    CHECK(near(lab_from_rgb({0, 0, 0}), {0, 0, 0}, 0.01F));
    CHECK(near(lab_from_rgb({1, 1, 1}), {100, 0, 0}, 0.02F));
    CHECK(near(lab_from_rgb({1, 0, 0}), {53.24F, 80.09F, 67.20F}, 0.05F));
    CHECK(near(lab_from_rgb({0, 1, 0}), {87.73F, -86.18F, 83.18F}, 0.05F));
    CHECK(near(lab_from_rgb({0, 0, 1}), {32.30F, 79.20F, -107.86F}, 0.05F));
    CHECK(near(lab_from_rgb({0.5F, 0.5F, 0.5F}), {53.39F, 0, 0}, 0.02F));
}

TEST_CASE("every color comes back from L*a*b*, and those outside the gamut are clamped")
{
    for (float r = 0; r <= 1; r += 0.125F)
        for (float g = 0; g <= 1; g += 0.125F)
            for (float b = 0; b <= 1; b += 0.125F)
                CHECK(near(rgb_from_lab(lab_from_rgb({r, g, b})), {r, g, b}, 1e-3F));
    const Vec3f outside = rgb_from_lab({100, 120, -120});
    CHECK((outside.x <= 1 && outside.y >= 0 && outside.z <= 1));
}

TEST_CASE("a picture's pixels are converted one by one")
{
    Raster8 picture(2, 1, 3);
    picture.values = {255, 0, 0, 10, 200, 77};
    const RasterF lab = lab_picture(picture);
    const Vec3f second = lab_from_rgb(Vec3f{10 / 255.0F, 200 / 255.0F, 77 / 255.0F});
    CHECK(near({lab.at(1, 0, 0), lab.at(1, 0, 1), lab.at(1, 0, 2)}, second, 1e-3F));
}

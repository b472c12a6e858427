#include "catch.h"

#include <fresco/images/recoloring.h>

#include <algorithm>

using namespace fresco;

namespace
{

constexpr int side = 100;
constexpr std::size_t pixels = 10'000;

/// Brown above, cream below, and a few pixels of blue.
Raster8 picture_with(int blue_pixels)
{
    Raster8 picture(side, side, 3);
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    {
        const auto color = static_cast<int>(pixel) < blue_pixels ? std::array<int, 3>{30, 60, 200}
                           : pixel < pixels / 2                  ? std::array<int, 3>{90, 50, 20}
                                                                 : std::array<int, 3>{240, 230, 200};
        std::ranges::copy(color, &picture.values[3 * pixel]);
    }
    return picture;
}

ColorMoments moments_of(const Raster8& picture)
{
    ColorMoments moments;
    for (std::size_t i = 0; i < picture.values.size(); i += 3)
        moments.add(Vec3d{double(picture.values[i]), double(picture.values[i + 1]), double(picture.values[i + 2])} * (1.0 / 255));
    return moments;
}

double apart(Vec3f a, Vec3f b)
{
    return length(vec_cast<double>(lab_from_rgb(a) - lab_from_rgb(b)));
}

constexpr Vec3f brown{90 / 255.0F, 50 / 255.0F, 20 / 255.0F};
constexpr Vec3f cream{240 / 255.0F, 230 / 255.0F, 200 / 255.0F};
constexpr Vec3f blue{30 / 255.0F, 60 / 255.0F, 200 / 255.0F};

}  // namespace

TEST_CASE("a color that the picture has enough of stays; one that it has little of becomes the nearest that it has")
{
    for (const int blue_pixels : {0, 10, 1000})
    {
        CAPTURE(blue_pixels);
        const Raster8 picture = picture_with(blue_pixels);
        const Recoloring recolored(moments_of(picture), picture, {});
        CHECK(apart(recolored(cream), cream) < 0.1);
        CHECK(apart(recolored(brown), brown) < 0.1);
        const Vec3f other = recolored(blue);
        if (blue_pixels == 1000)
            CHECK(apart(other, blue) < 0.1);
        else
            CHECK(apart(other, brown) < (blue_pixels == 0 ? 8 : 40));
        CHECK(apart(other, brown) < apart(blue, brown) + 0.1);
    }
}

TEST_CASE("pixels that do not count are no colors of the picture")
{
    const Raster8 picture = picture_with(2000);
    std::vector<std::uint8_t> opaque(pixels, 1);
    std::fill_n(opaque.begin(), 2000, std::uint8_t{0});
    const Recoloring recolored(moments_of(picture_with(0)), picture, opaque);
    CHECK(apart(recolored(blue), brown) < 20);
    CHECK(apart(Recoloring(moments_of(picture), picture, {})(blue), blue) < 0.1);
}

TEST_CASE("a picture without colors to count changes nothing")
{
    const Raster8 picture = picture_with(0);
    const std::vector<std::uint8_t> none(pixels, 0);
    CHECK(Recoloring(moments_of(picture), picture, none)(blue) == blue);
}

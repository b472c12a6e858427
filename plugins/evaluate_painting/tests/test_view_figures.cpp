#include "catch.h"
#include "figure_table.h"
#include "pictures.h"
#include "view_figures.h"

#include <fresco/images/filters.h>
#include <fresco/testing_scenes.h>

#include <cstdlib>

using namespace fresco;
using namespace pictures;

namespace
{
constexpr int width_px = 320;
constexpr int height_px = 256;

Raster8 blurred_picture(const Raster8& rgb, double sigma_px)
{
    RasterF values(rgb.width, rgb.height, 3);
    std::ranges::transform(rgb.values, values.values.begin(), [](std::uint8_t v) { return static_cast<float>(v) / 255; });
    const RasterF soft = blurred(values, sigma_px);
    return changed(rgb, [&](int x, int y) { return Vec3f{soft.at(x, y, 0), soft.at(x, y, 1), soft.at(x, y, 2)}; });
}

ViewFigures figures_of(const Raster8& view, const StylePicture& style)
{
    return view_figures(view, judged_pixels(covered_pixels(view)), style);
}

double edges(const Raster8& view, const Raster8& camera)
{
    return edge_correlation(view, covered_pixels(view), camera);
}
}  // namespace

TEST_CASE("a palette knows its colors and what is near them")
{
    Random random(1);
    RasterF lab(50, 1, 3);
    const auto draw = [&]
    {
        return Vec3f{static_cast<float>(100 * random.uniform()), static_cast<float>(60 * random.normal() / 3),
                     static_cast<float>(60 * random.normal() / 3)};
    };
    for (int x = 0; x < lab.width; ++x)
    {
        const Vec3f color = draw();
        lab.at(x, 0, 0) = color.x;
        lab.at(x, 0, 1) = color.y;
        lab.at(x, 0, 2) = color.z;
    }
    const Palette palette(lab);
    int near = 0;
    for (int i = 0; i < 3000; ++i)
    {
        const Vec3f color = draw();
        float nearest = 1e9F;
        for (int x = 0; x < lab.width; ++x)
        {
            const auto cell = [&](int c) { return 2 * std::nearbyint(lab.at(x, 0, c) / 2); };
            nearest = std::min(nearest, length(color - Vec3f{cell(0), cell(1), cell(2)}));
        }
        REQUIRE(palette.is_near(color) == (nearest <= 10));
        near += nearest <= 10 ? 1 : 0;
    }
    CHECK(near > 300);
    CHECK(near < 2700);
}

TEST_CASE("the picture itself is what it is compared with")
{
    const Raster8 picture = painting(width_px, height_px, 7);
    const StylePicture style(picture);
    const ViewFigures own = figures_of(picture, style);
    CHECK(own.off_palette == 0);
    CHECK(own.coherence == Approx(1).epsilon(1e-9));
    CHECK(own.chroma_noise == Approx(1).epsilon(1e-9));
    CHECK(own.strokes == Approx(1).epsilon(1e-9));
    // So is it in part, and with the painting in twice the size.
    const ViewFigures part = figures_of(with_hole(picture, 40), style);
    CHECK(part.off_palette == 0);
    CHECK(part.coherence == Approx(1).margin(0.1));
    CHECK(part.chroma_noise == Approx(1).margin(0.1));
    CHECK(part.strokes == Approx(1).margin(0.1));
    CHECK(figures_of(picture, StylePicture(resized(picture, 2 * width_px, 2 * height_px))).strokes == Approx(1).margin(0.1));
    // Another painting by the same hand.
    const ViewFigures other = figures_of(painting(width_px, height_px, 8), style);
    CHECK(other.off_palette < 0.005);
    CHECK(other.coherence == Approx(1).margin(0.15));
    CHECK(other.chroma_noise == Approx(1).margin(0.15));
    CHECK(other.strokes == Approx(1).margin(0.15));
}

TEST_CASE("OpenCV's filters and colors give the same figures")
{
    // cvtColor (32-bit float), GaussianBlur, Sobel and erode of OpenCV 4.6 on the same pictures; off_palette over every 16th
    // pixel.
    const Raster8 picture = painting(width_px, height_px, 7);
    const StylePicture style(picture);
    const Raster8 camera = photograph(width_px, height_px, 2);
    const Raster8 room = recolored(camera, picture);
    const auto check = [&](const Raster8& view, const ViewFigures& expected)
    {
        const ViewFigures found = figures_of(view, style);
        CHECK(found.off_palette == Approx(expected.off_palette).margin(0.02));
        CHECK(found.coherence == Approx(expected.coherence).epsilon(0.005));
        CHECK(found.chroma_noise == Approx(expected.chroma_noise).epsilon(0.005));
        CHECK(found.strokes == Approx(expected.strokes).epsilon(0.005));
    };
    check(with_hole(painting(width_px, height_px, 8), 40), {0, 0.9417, 0.9697, 1.0495});
    check(with_hole(room, 40), {0.2012, 1.3612, 1.4936, 0.4456});
    check(noisy(room, 0, 15), {0.5779, 1.3303, 6.0312, 0.4283});
    check(noisy(picture, 25, 0), {0.2816, 0.4153, 0.3347, 1.2753});
    CHECK(edges(room, camera) == Approx(0.9366).margin(0.002));
    // Black beyond the hole reaches a little of what is left there.
    CHECK(edges(with_hole(room, 40), camera) == Approx(0.9424).margin(0.01));
}

TEST_CASE("each sabotage moves its own figure out of the wanted range")
{
    const Raster8 picture = painting(width_px, height_px, 7);
    const StylePicture style(picture);
    const Raster8 room = recolored(photograph(width_px, height_px, 2), picture);

    CHECK(figures_of(blurred_picture(picture, 3), style).strokes < 0.6);
    CHECK(figures_of(room, style).strokes < 0.6);
    CHECK(figures_of(noisy(room, 0, 15), style).chroma_noise > 1.6);
    CHECK(figures_of(noisy(picture, 0, 15), style).chroma_noise > 1.6);
    CHECK(figures_of(noisy(picture, 25, 0), style).coherence < 0.8);
    const auto swapped = [&](int x, int y)
    {
        const Vec3f color = color_at(picture, x, y);
        return Vec3f{color.y, color.z, color.x};
    };
    CHECK(figures_of(changed(picture, swapped), style).off_palette > 0.3);
    const auto gray = [&](int x, int y)
    {
        const Vec3f color = color_at(picture, x, y);
        return Vec3f{color.y, color.y, color.y};
    };
    CHECK(figures_of(changed(picture, gray), style).chroma_noise < 0.6);
}

TEST_CASE("a view without detail has none of the figures")
{
    const StylePicture style(painting(width_px, height_px, 7));
    const ViewFigures flat = figures_of(Raster8(width_px, height_px, 3, 120), style);
    CHECK(flat.coherence == 0);
    CHECK(flat.chroma_noise == 0);
    CHECK(flat.strokes < 1e-4);
}

TEST_CASE("pixels that are judged lie inside of what is covered")
{
    Raster8 view(100, 90, 4);
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 60; ++x)
            view.at(x, y, 3) = 1;
    const JudgedPixels pixels = judged_pixels(covered_pixels(view));
    CHECK(pixels.count == 3404);  // 46 x 74
    CHECK(pixels.mask.at(53, 45) == 1);
    CHECK(pixels.mask.at(54, 45) == 0);
    CHECK(pixels.mask.at(8, 8) == 1);
    CHECK(pixels.mask.at(7, 8) == 0);
    // Without alpha, black is nothing.
    Raster8 rgb(2, 1, 3, 1);
    CHECK(covered_pixels(rgb).values == std::vector<std::uint8_t>{0, 0});
    rgb.at(1, 0, 2) = 4;
    CHECK(covered_pixels(rgb).values == std::vector<std::uint8_t>{0, 1});
}

TEST_CASE("style pictures of other kinds, and those that cannot be compared with")
{
    const Raster8 picture = painting(width_px, height_px, 7);
    const Raster8 gray = testing::picture(
        width_px, height_px, [&](int x, int y, int) { return picture.at(x, y, 1); }, 1);
    const StylePicture gray_style(gray);
    CHECK_FALSE(gray_style.has_chroma());
    CHECK(std::isnan(figures_of(picture, gray_style).chroma_noise));
    CHECK(figures_of(picture, gray_style).strokes > 0.5);

    // Transparent is white: a hole adds white to the palette.
    const StylePicture holed(with_hole(picture, 40));
    CHECK(holed.palette.is_near({100, 0, 0}));
    CHECK_FALSE(StylePicture(picture).palette.is_near({100, 0, 0}));

    CHECK_THROWS_WITH(StylePicture(Raster8(300, 300, 3, 200)), Catch::Contains("single color"));
    CHECK_THROWS_WITH(StylePicture(Raster8(1, 17, 3)), Catch::Contains("16 times the shorter one"));
    CHECK_THROWS_WITH(StylePicture(Raster8(9, 9, 2)), Catch::Contains("with 2 channels"));
}

TEST_CASE("edges are those of the camera picture, or of another")
{
    const Raster8 camera = photograph(width_px, height_px, 2);
    CHECK(edges(camera, camera) == Approx(1).epsilon(1e-9));
    CHECK(edges(with_hole(camera, 40), camera) == Approx(1).epsilon(1e-5));
    CHECK(edges(camera, resized(camera, 2 * width_px, 2 * height_px)) > 0.98);
    CHECK(std::abs(edges(photograph(width_px, height_px, 3), camera)) < 0.2);
    CHECK(std::abs(edges(painting(width_px, height_px, 7), camera)) < 0.2);
    CHECK(edges(recolored(camera, painting(width_px, height_px, 7)), camera) > 0.6);
    const auto negative = [&](int x, int y) { return Vec3f{1, 1, 1} - color_at(camera, x, y); };
    CHECK(edges(changed(camera, negative), camera) < -0.8);
    CHECK(std::isnan(edges(with_hole(camera, 190), camera)));
    CHECK(std::isnan(edges(Raster8(width_px, height_px, 3, 99), camera)));
}

TEST_CASE("mean and worst of views, by what is wanted")
{
    const std::vector<std::string> views{"a", "b", "c", "d"};
    const auto worst = [&](Wanted wanted, const std::vector<double>& values)
    { return over_views("figure", wanted, values, views)->worst->view; };
    CHECK(worst({0.5}, {0.9, 0.4, 0.7, 0.8}) == "b");
    CHECK(worst({.high = 0.005}, {0.001, 0, 0.004, 0.002}) == "c");
    CHECK(worst({0.8, 1.2}, {1, 0.9, 1.15, 0.95}) == "c");
    CHECK(worst({0.8, 1.2}, {1, 0.7, 1.25, 0.95}) == "b");
    // The first of equal ones; views without a value do not count.
    CHECK(worst({0.5}, {std::nan(""), 0.4, 0.4, 0.8}) == "b");
    const auto some = over_views("figure", {0.5}, std::vector<double>{1, std::nan(""), INFINITY, 2}, views);
    CHECK(some->value == 1.5);
    CHECK_FALSE(over_views("figure", {0.5}, std::vector<double>(4, std::nan("")), views));
}

TEST_CASE("a room is the less legible, the broader the strokes that dissolve it, in whatever colors")
{
    const Raster8 camera = photograph(width_px, height_px, 2);
    const auto legible = [&](const Raster8& view) { return legibility(view, covered_pixels(view), camera); };
    const auto in_cells = [&](int side)
    { return changed(camera, [&](int x, int y) { return color_at(camera, x / side * side, y / side * side); }); };
    const double small = legible(in_cells(6));
    const double broad = legible(in_cells(14));
    const double dissolved = legible(in_cells(40));
    CHECK(legible(camera) == Approx(1).margin(0.02));
    CHECK(small < 0.9);
    CHECK(broad < small - 0.1);
    CHECK(dissolved < broad - 0.1);
    // In the negative, edges point the other way.
    const Raster8 negative = changed(camera, [&](int x, int y) { return Vec3f{1, 1, 1} - color_at(camera, x, y); });
    CHECK(legible(negative) > 0.5);
    CHECK(edges(negative, camera) < -0.8);
    CHECK(std::abs(legible(photograph(width_px, height_px, 3))) < 0.05);
    CHECK(std::abs(legible(Raster8(width_px, height_px, 3, 120))) < 0.02);
    CHECK(legible(with_hole(camera, 40)) == Approx(1).margin(0.02));
    CHECK(std::isnan(legibility(camera, Raster8(width_px, height_px), camera)));
}

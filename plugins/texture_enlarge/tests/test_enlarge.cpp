#include "catch.h"
#include "enlarge.h"

#include "plain_enlarge.h"
#include "samples.h"

#include <fresco/testing.h>
#include <fresco/texturing/texel_faces.h>

using namespace samples;

namespace
{

double luminance(const Raster8& rgb, int x, int y)
{
    return 0.2126 * rgb.at(x, y, 0) + 0.7152 * rgb.at(x, y, 1) + 0.0722 * rgb.at(x, y, 2);
}

/// Mean square of the finest band of a Laplacian pyramid (Burt and Adelson's kernel of five) over a rectangle.
double finest_band_energy(const Raster8& rgb, int left, int top, int right, int bottom)
{
    constexpr std::array<double, 5> kernel{1 / 16.0, 4 / 16.0, 6 / 16.0, 4 / 16.0, 1 / 16.0};
    double sum = 0;
    for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x)
        {
            double mean = 0;
            for (int j = -2; j <= 2; ++j)
                for (int i = -2; i <= 2; ++i)
                    mean += kernel[static_cast<std::size_t>(i + 2)] * kernel[static_cast<std::size_t>(j + 2)] *
                            luminance(rgb, x + i, y + j);
            sum += (luminance(rgb, x, y) - mean) * (luminance(rgb, x, y) - mean);
        }
    return sum / (static_cast<double>(right - left) * (bottom - top));
}

}  // namespace

TEST_CASE("copies that continue each other give the picture itself, turned, in mirrored charts too")
{
    // Waves long enough for any interpolation.
    Raster8 picture(200, 160, 3);
    const auto wave = [](double x, double y, int c) { return 128 + 100 * std::sin(0.11 * x + c) * std::cos(0.09 * y - c); };
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) = static_cast<std::uint8_t>(std::lround(wave(x + 0.5, y + 0.5, c)));
    for (const bool mirrored : {false, true})
    {
        CAPTURE(mirrored);
        Mesh mesh = fresco::testing::two_chart_wall();
        if (mirrored)
            for (Vec2f& uv : mesh.texcoords)
                uv.x = 1 - uv.x;
        constexpr double angle = 0.75;
        constexpr double step = 1.5;
        const auto place = [&](double x, double y)
        {
            const double down = mirrored ? -1 : 1;
            return Vec2d{100 + step * (std::cos(angle) * (x - 32) - down * std::sin(angle) * (y - 50)),
                         80 + step * (std::sin(angle) * (x - 32) + down * std::cos(angle) * (y - 50))};
        };
        SourceMap map = empty_map(mesh, 64, picture, step);
        for_each_wall_texel(64,
                            [&](int x, int y)
                            {
                                const Vec2d at = place(x + 0.5, y + 0.5);
                                map.set_place(x, y, {{static_cast<float>(at.x), static_cast<float>(at.y)}, float{angle}});
                            });
        testing::TestRun run;
        const Raster8 large = enlarge::enlarged(map, picture, mesh, 256, run).picture;
        double worst = 0;
        for (int y = 156; y < 228; ++y)
            for (int x = 28; x < 100; ++x)
                for (int c = 0; c < 3; ++c)
                {
                    const Vec2d at = place((x + 0.5) / 4, (y + 0.5) / 4);
                    worst = std::max(worst, std::abs(large.at(x, y, c) - wave(at.x, at.y, c)));
                }
        CHECK(worst < 2);
    }
}

TEST_CASE("every texel is what the plain method gives, at whole and odd factors")
{
    const Mesh mesh = fresco::testing::two_chart_wall();
    const Raster8 picture = detailed_picture(128, 96);
    const SourceMap map = patched_map(mesh, 40, picture, 1.3);
    for (const int size_px : {40, 97, 160})
    {
        CAPTURE(size_px);
        testing::TestRun run;
        const enlarge::Enlarged result = enlarge::enlarged(map, picture, mesh, size_px, run);
        // Where a texel is wider than a pixel the picture is made smaller first.
        const double along_texel = enlarge::pixels_per_texel(map, picture.width, size_px);
        CHECK(along_texel == Approx(1.3 * 40 / size_px));
        const auto side = [&](int pixels) { return static_cast<int>(std::lround(pixels / std::max(1.0, along_texel))); };
        const Raster8 seen = resized(picture, side(picture.width), side(picture.height));
        SourceMap scaled = map;
        scaled.picture_width = seen.width;
        scaled.picture_height = seen.height;
        scaled.pixels_per_texel *= static_cast<float>(seen.width) / static_cast<float>(picture.width);
        std::size_t painted = 0;
        std::size_t apart = 0;
        for (int y = 0; y < size_px; ++y)
            for (int x = 0; x < size_px; ++x)
            {
                const auto of_map = [&](int i) { return static_cast<int>((i + 0.5) * 40 / size_px); };
                if (!map.place(of_map(x), of_map(y)))
                    continue;
                ++painted;
                const auto plain = plain::enlarged(scaled, seen, size_px, x, y);
                for (int c = 0; c < 3; ++c)
                    if (std::abs(result.picture.at(x, y, c) - plain[static_cast<std::size_t>(c)]) > 2.5)
                    {
                        ++apart;
                        break;
                    }
            }
        CHECK(static_cast<double>(painted) > 0.15 * size_px * size_px);
        CHECK(result.painted_share == Approx(static_cast<double>(painted) / (double{1} * size_px * size_px)));
        CHECK(apart < painted / 200);
    }
}

TEST_CASE("the finest band keeps at least 0.9 of the picture's energy, within copies and where they meet")
{
    const Mesh mesh = fresco::testing::two_chart_wall();
    // Only fine detail: where copies meet, no edge between two colors adds to it.
    const Raster8 picture = detailed_picture(512, 384, {2, 4});
    const double original = finest_band_energy(picture, 8, 8, 504, 376);
    testing::TestRun run;
    const auto share = [&](int side)
    {
        const SourceMap map = patched_map(mesh, 128, picture, 4, side);
        return finest_band_energy(enlarge::enlarged(map, picture, mesh, 512, run).picture, 66, 322, 190, 446) / original;
    };
    // One copy or two over each chart, at odd angles.
    CHECK(share(64) > 0.9);
    CHECK(share(64) < 1.15);
    CHECK(share(4) > 0.9);
}

TEST_CASE("no color crosses from chart to chart, and the gutter continues the nearest")
{
    Mesh mesh = fresco::testing::two_chart_wall();
    // The charts touch.
    for (Vec2f& uv : mesh.texcoords)
        uv.x = uv.x < 0.5F ? uv.x + 0.12F : uv.x - 0.08F;
    Raster8 picture(64, 64, 3);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            picture.at(x, y, x < 32 ? 0 : 2) = 200;
    SourceMap map = empty_map(mesh, 16, picture, 0.5);
    testing::TestRun run;
    const texturing::Charts charts = texturing::find_charts(mesh);
    const texturing::TexelFaces faces = texturing::find_texel_faces(mesh, charts, 16, run);
    std::vector<int> chart_of(256, -1);
    for (std::size_t texel = 0; texel < 256; ++texel)
        if (faces.covered(texel))
        {
            chart_of[texel] = static_cast<int>(charts.of_face[faces.face[texel]]);
            map.set_place(static_cast<int>(texel % 16), static_cast<int>(texel / 16),
                          {{chart_of[texel] == 0 ? 10.0F : 54.0F, 30}, 0});
        }
    const Raster8 large = enlarge::enlarged(map, picture, mesh, 128, run).picture;
    std::size_t wrong = 0;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x)
        {
            const int chart = chart_of[static_cast<std::size_t>(y / 8 * 16 + x / 8)];
            const bool red = large.at(x, y, 0) == 200 && large.at(x, y, 2) == 0;
            const bool blue = large.at(x, y, 2) == 200 && large.at(x, y, 0) == 0;
            wrong += !(red || blue) || (chart == 0 && blue) || (chart == 1 && red);
        }
    CHECK(wrong == 0);
}

TEST_CASE("a larger copy of the picture gives the same motifs, sharper")
{
    const Mesh mesh = fresco::testing::two_chart_wall();
    const Raster8 full = detailed_picture(512, 384, {2, 4});
    const Raster8 half = resized(full, 256, 192);
    const SourceMap map = patched_map(mesh, 64, half, 4);
    testing::TestRun run;
    const Raster8 sharp = enlarge::enlarged(map, full, mesh, 512, run).picture;
    const Raster8 soft = resized(enlarge::enlarged(map, half, mesh, 256, run).picture, 512, 512);
    double apart = 0;
    double noise = 0;
    for (int y = 312; y < 456; ++y)
        for (int x = 56; x < 200; ++x)
        {
            apart += std::pow(luminance(sharp, x, y) - luminance(soft, x, y), 2);
            noise += std::pow(luminance(sharp, x, y) - luminance(sharp, x + 40, y), 2);
        }
    CHECK(apart < noise / 2);
    CHECK(finest_band_energy(sharp, 56, 312, 200, 456) > 2 * finest_band_energy(soft, 56, 312, 200, 456));
}

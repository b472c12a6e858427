#include "mix.h"
#include "two_chart_wall.h"

#include <fresco/testing.h>
#include <fresco/texturing/charts.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
constexpr int wall_px = 160;

TexelFaces wall_faces()
{
    const Mesh mesh = two_chart_wall();
    return find_texel_faces(mesh, find_charts(mesh), wall_px, testing::TestRun());
}

/// A function of the place on the wall (0 to 2 m, 0 to 1 m), gray.
template <class Function>
RasterF painted_by(Function value)
{
    const Mesh mesh = two_chart_wall();
    const TexelFaces faces = wall_faces();
    RasterF rgb(wall_px, wall_px, 3, 0.5F);
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        if (faces.covered(texel))
        {
            const Vec3f at = texel_position(mesh, faces, texel);
            for (std::size_t c = 0; c < 3; ++c)
                rgb.values[3 * texel + c] = static_cast<float>(value(at));
        }
    return rgb;
}

RasterF mixed(const RasterF& photo, const RasterF& painting, double color, double strokes, int threads = 2)
{
    const testing::TestRun run(threads);
    return mix(photo, recolored(photo, painting, two_chart_wall(), wall_faces(), 0.3, run), painting, color, strokes);
}

double long_wave(Vec3f at)
{
    return 0.2 * std::sin(2 * std::numbers::pi * at.x / 1.5);
}
double short_wave(Vec3f at)
{
    return 0.2 * std::sin(2 * std::numbers::pi * at.y / 0.08);
}

/// Share of a pattern in a picture that is 0.5 plus patterns, in the middle of the wall's left half.
template <class Function>
double share_of(const RasterF& picture, Function pattern)
{
    const Mesh mesh = two_chart_wall();
    const TexelFaces faces = wall_faces();
    double product = 0;
    double square = 0;
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        if (faces.inside[texel])
            if (const Vec3f at = texel_position(mesh, faces, texel); at.x > 0.2 && at.x < 1.8 && at.y > 0.2 && at.y < 0.8)
            {
                product += pattern(at) * (double{picture.values[3 * texel]} - 0.5);
                square += pattern(at) * pattern(at);
            }
    return product / square;
}
}  // namespace

TEST_CASE("mix: both ends are the textures themselves, and equal shares a straight line between them")
{
    const RasterF photo = painted_by([](Vec3f at) { return 0.5 + long_wave(at); });
    const RasterF painting = painted_by([](Vec3f at) { return 0.4 + short_wave(at); });
    CHECK(mixed(photo, painting, 0, 0).values == photo.values);
    CHECK(mixed(photo, painting, 1, 1).values == painting.values);
    const RasterF half = mixed(photo, painting, 0.5, 0.5);
    double largest = 0;
    for (std::size_t i = 0; i < half.values.size(); ++i)
        largest = std::max(largest, std::abs(half.values[i] - (double{photo.values[i]} + double{painting.values[i]}) / 2));
    CHECK(largest < 1e-6);
}

TEST_CASE("mix: colors and strokes come apart")
{
    const RasterF photo = painted_by([](Vec3f) { return 0.5; });
    const RasterF painting = painted_by([](Vec3f at) { return 0.5 + long_wave(at) + short_wave(at); });
    const RasterF strokes = mixed(photo, painting, 0, 1);
    CHECK(share_of(strokes, short_wave) > 0.95);
    CHECK(share_of(strokes, long_wave) < 0.15);
    const RasterF colors = mixed(photo, painting, 1, 0);
    CHECK(share_of(colors, short_wave) < 0.05);
    CHECK(share_of(colors, long_wave) > 0.85);
}

TEST_CASE("mix: nothing shows where the atlas is cut")
{
    // Smooth on the wall: without strokes it stays so, also across x = 1 m, whose sides lie at opposite ends of the atlas.
    const RasterF photo = painted_by([](Vec3f) { return 0.5; });
    const RasterF painting = painted_by([](Vec3f at) { return 0.5 + long_wave(at); });
    const RasterF colors = mixed(photo, painting, 1, 0);
    const auto at = [&](float u, float v)
    {
        float rgb[3];
        sample_bilinear(colors, u, v, rgb);
        return rgb[0];
    };
    for (float up = 0.05F; up < 1; up += 0.1F)
    {
        const float left = at(0.395F, 0.1F + 0.3F * up);
        const float right = at(0.895F, 0.4F - 0.3F * up);
        CHECK(std::abs(left - right) < 0.02F);
    }
}

TEST_CASE("mix: the same for any number of threads, and canceled on demand")
{
    const RasterF photo = painted_by([](Vec3f at) { return 0.5 + long_wave(at); });
    const RasterF painting = painted_by([](Vec3f at) { return 0.5 + short_wave(at); });
    CHECK(mixed(photo, painting, 0.3, 0.8, 1).values == mixed(photo, painting, 0.3, 0.8, 4).values);
    testing::TestRun run;
    run.cancel_after(1);
    CHECK_THROWS_AS(recolored(photo, painting, two_chart_wall(), wall_faces(), 0.3, run), Canceled);
}

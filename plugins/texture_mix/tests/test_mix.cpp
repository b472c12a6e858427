#include "catch.h"
#include "mix.h"
#include "surface_average.h"
#include "two_chart_wall.h"

#include <fresco/testing.h>
#include <fresco/texturing/charts.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

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
    return mix(photo, painting, two_chart_wall(), wall_faces(), 0.3, {color, strokes}, run).rgb;
}

/// 1 m², all normals differ, its border between texels.
Mesh hill()
{
    constexpr std::uint32_t side = 9;
    Mesh mesh;
    std::vector<Vec2f> texcoords;
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x)
        {
            const Vec2f at{static_cast<float>(x) / (side - 1), static_cast<float>(y) / (side - 1)};
            mesh.positions.push_back({at.x, at.y, 0.2F * std::sin(5 * at.x) * std::cos(4 * at.y)});
            texcoords.push_back({0.0523F + 0.9F * at.x, 0.0517F + 0.9F * at.y});
        }
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x)
        {
            const std::uint32_t v = y * side + x;
            mesh.triangles.push_back({v, v + 1, v + side});
            mesh.triangles.push_back({v + 1, v + side + 1, v + side});
        }
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle)
            mesh.texcoords.push_back(texcoords[corner]);
    return mesh;
}

RasterF noise(unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    RasterF rgb(wall_px, wall_px, 3);
    for (float& value : rgb.values)
        value = unit(random);
    return rgb;
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
    const Mix middle = mix(photo, painting, two_chart_wall(), wall_faces(), 0.3, {0.5, 0.5}, testing::TestRun());
    const RasterF& half = middle.rgb;
    double largest = 0;
    for (std::size_t i = 0; i < half.values.size(); ++i)
        largest = std::max(largest, std::abs(half.values[i] - (double{photo.values[i]} + double{painting.values[i]}) / 2));
    CHECK(largest < 1e-6);
    const TexelFaces faces = wall_faces();
    std::size_t rounded = 0;
    double sum = 0;
    double count = 0;
    for (std::size_t i = 0; i < half.values.size(); ++i)
    {
        rounded += middle.photo.values[i] == std::lround(255 * photo.values[i]) &&
                   middle.painted.values[i] == std::lround(255 * painting.values[i]);
        if (faces.inside[i / 3])
        {
            sum += std::abs(255 * (double{photo.values[i]} - double{painting.values[i]}) / 2);
            ++count;
        }
    }
    CHECK(rounded == half.values.size());
    CHECK(middle.from_photo == Approx(sum / count));
    CHECK(middle.from_painted == Approx(sum / count));
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

TEST_CASE("mix: the mean along rows is that of each texel by itself")
{
    const Mesh mesh = hill();
    const TexelFaces faces = find_texel_faces(mesh, find_charts(mesh), wall_px, testing::TestRun());
    const RasterF photo = noise(1);
    const RasterF painting = noise(2);
    const auto normals = vertex_normals(mesh);
    const auto normal = [&](std::size_t texel)
    {
        const auto weights = texel_weights(mesh, faces, texel);
        Vec3f sum;
        for (std::size_t i = 0; i < 3; ++i)
            sum += normals[mesh.triangles[faces.face[texel]][i]] * static_cast<float>(weights[i]);
        return normalized(sum);
    };
    const auto difference = [&](std::size_t texel)
    {
        return Vec3f{painting.values[3 * texel] - photo.values[3 * texel],
                     painting.values[3 * texel + 1] - photo.values[3 * texel + 1],
                     painting.values[3 * texel + 2] - photo.values[3 * texel + 2]};
    };
    // So small a split that every texel is a sample.
    constexpr double split_m = 0.15;
    const auto [lowest, highest] = std::ranges::minmax(mesh.positions, {}, &Vec3f::z);
    SurfaceAverage average({0, 0, lowest.z}, {1, 1, highest.z}, split_m);
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        if (faces.inside[texel])
            average.add(texel_position(mesh, faces, texel), normal(texel), difference(texel));

    const Mix mixed = mix(photo, painting, mesh, faces, split_m, {1, 0}, testing::TestRun());
    double largest = 0;
    double steps = 0;
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
    {
        Vec3f expected{photo.values[3 * texel], photo.values[3 * texel + 1], photo.values[3 * texel + 2]};
        if (faces.covered(texel))
            expected += SurfaceAverage::Lookup(average).at(texel_position(mesh, faces, texel), normal(texel), {});
        for (std::size_t c = 0; c < 3; ++c)
        {
            const double value = std::clamp(double{(&expected.x)[c]}, 0.0, 1.0);
            largest = std::max(largest, std::abs(double{mixed.rgb.values[3 * texel + c]} - value));
            steps = std::max(steps, std::abs(mixed.colors.values[3 * texel + c] - 255 * value));
        }
    }
    CHECK(largest < 1e-4);
    CHECK(steps < 0.51);
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
    CHECK_THROWS_AS(mix(photo, painting, two_chart_wall(), wall_faces(), 0.3, {}, run), Canceled);
}

#include "catch.h"
#include "kernels_here.h"
#include "shading_kernel.h"
#include "view_cases.h"

#include <fresco/parallel.h>
#include <fresco/uv_mapping/into_camera.h>
#include <fresco/uv_mapping/shading.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <tuple>
#include <vector>

using namespace fresco;

namespace
{
struct Shaded
{
    UvMap map;
    RasterF met;
    PixelCounts counts;
};

Shaded shaded(const Mesh& mesh, const Camera& camera, const FaceMap& faces,
              const shading::Kernel& kernel = shading::fastest_kernel())
{
    const int w = faces.width, h = faces.height;
    Shaded result{{RasterF(w, h, 2, 9), RasterF(w, h, 1, 9), RasterF(w, h, 1, 9), Raster8(w, h, 1, 9)}, RasterF(w, h, 1, 9), {}};
    result.counts = FaceShader(mesh, kernel).shade(camera, faces, 0, h, result.map, result.met);
    return result;
}
}  // namespace

TEST_CASE("a ray beside its face gets a point of the face")
{
    Mesh mesh;
    cases::add_face(mesh, {-0.1F, -0.1F, 2}, {0, 0.1F, 2}, {0.1F, -0.1F, 2});
    mesh.texcoords = {{0.25F, 0.25F}, {0.5F, 0.75F}, {0.75F, 0.25F}};
    const auto result = shaded(mesh, testing::camera(10, 10, 5), FaceMap(10, 10, 1, 0));
    CHECK(result.counts.valid == 100);
    CHECK(std::ranges::all_of(result.map.uv.values, [](float v) { return v >= 0.25F && v <= 0.75F; }));
    CHECK(std::ranges::all_of(result.map.depth.values, [](float v) { return v == Approx(2); }));
}

// The tests of rendering::RasterFinder compare the fastest one with plain geometry.
TEST_CASE("every kernel gives a row of any width the values of the fastest one")
{
    // Two faces of a slanted wall before a void; the row's pixels see one, the other, or nothing.
    Mesh mesh;
    mesh.positions = {{-9, -9, 3}, {9, -9, 4}, {9, 9, 5}, {-9, 9, 4}};
    mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
    mesh.texcoords = {{0, 1}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}};
    for (const shading::Kernel* kernel :
         testing::kernels_here(shading::base_kernel(), shading::avx2_kernel(), shading::avx512_kernel()))
        for (int width = 1; width <= 35; ++width)
        {
            INFO(kernel->name << ", " << width);
            FaceMap faces(width, 3);
            for (std::size_t i = 0; i < faces.values.size(); ++i)
                faces.values[i] = i % 5 == 3 ? no_face : static_cast<std::uint32_t>(i / 3 % 2);
            const Camera camera = testing::camera(width, 3, 2.0 * width);
            const auto found = shaded(mesh, camera, faces, *kernel), expected = shaded(mesh, camera, faces);
            CHECK(found.counts == expected.counts);
            CHECK(found.map.valid == expected.map.valid);
            CHECK(found.counts.nothing == std::count(faces.values.begin(), faces.values.end(), no_face));
            for (std::size_t i = 0; i < faces.values.size(); ++i)
            {
                CHECK(found.map.depth.values[i] == Approx(expected.map.depth.values[i]).epsilon(1e-6));
                CHECK((faces.values[i] == no_face ? std::isinf(found.met.values[i])
                                                  : found.met.values[i] == found.map.depth.values[i]));
                CHECK(found.map.uv.values[2 * i] == Approx(expected.map.uv.values[2 * i]).margin(1e-6));
                CHECK(found.map.uv.values[2 * i + 1] == Approx(expected.map.uv.values[2 * i + 1]).margin(1e-6));
                CHECK(found.map.cosine.values[i] == Approx(expected.map.cosine.values[i]).margin(1e-6));
            }
        }
}

TEST_CASE("the cracks that are closed are those that a look at every pixel finds")
{
    std::mt19937 random(2);
    for (int width = 3; width < 60; ++width)
    {
        RasterF met(width, 5, 1, 1);
        for (std::size_t i = 0; i + 2 < met.values.size(); ++i)
            if (random() % 40 == 0)
            {
                met.values[i] = 2;
                met.values[i + 2] = std::numeric_limits<float>::infinity();
            }
        UvMap map{RasterF(width, 5, 2, 0.5F), RasterF(width, 5), RasterF(width, 5), Raster8(width, 5, 1, 1)};
        for (int y = 0; y < 5; ++y)
            map.valid.at(width / 2, y) = 0;  // The back of a face.
        const auto closed = FaceShader::close_cracks(met, 0, 5, map);
        std::int64_t cracks = 0;
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < width; ++x)
            {
                const bool crack = x != width / 2 && seen_through_crack(met, x, y);
                cracks += crack ? 1 : 0;
                CHECK(map.valid.at(x, y) == (crack || x == width / 2 ? 0 : 1));
                CHECK(map.uv.at(x, y, 1) == (crack ? 0.0F : 0.5F));
            }
        CHECK(closed == cracks);
        if (width == 59)
            CHECK(cracks > 0);
    }
}

TEST_CASE("a pixel more than 5 cm behind all eight neighbors is seen through a crack")
{
    constexpr float nothing = std::numeric_limits<float>::infinity();
    // The pixel's depth among neighbors at 1, and the depth of one of them.
    for (const auto& [depth, other, crack] : {std::tuple{1.06F, 1.0F, true},
                                              {1.04F, 1.0F, false},
                                              {1.0F, 1.0F, false},
                                              {0.5F, 1.0F, false},
                                              {2.0F, 1.97F, false},
                                              {2.0F, 5.0F, false},
                                              {2.0F, nothing, false}})
    {
        RasterF met(3, 3, 1, 1);
        met.at(1, 1) = depth;
        met.at(1, 2) = other;
        CHECK(seen_through_crack(met, 1, 1) == crack);
        CHECK_FALSE(seen_through_crack(met, 0, 1));
    }
}

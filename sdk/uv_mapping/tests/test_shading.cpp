#include "view_cases.h"

#include <fresco/uv_mapping/into_camera.h>
#include <fresco/uv_mapping/shading.h>

#include <catch2/catch.hpp>

using namespace fresco;

namespace
{
struct Shaded
{
    UvMap map;
    RasterF met;
    PixelCounts counts;
};

/// Every pixel sees `face`, whatever its ray passes by.
Shaded shaded(const Mesh& mesh, const Camera& camera, std::uint32_t face)
{
    const int w = camera.intrinsics.width;
    const int h = camera.intrinsics.height;
    Shaded result{{RasterF(w, h, 2, 9), RasterF(w, h, 1, 9), RasterF(w, h, 1, 9), Raster8(w, h, 1, 9)}, RasterF(w, h, 1, 9), {}};
    result.counts = FaceShader(mesh).shade(camera, FaceMap(w, h, 1, face), 0, h, result.map, result.met);
    return result;
}
}  // namespace

TEST_CASE("a ray beside its face gets a point of the face")
{
    Mesh mesh;
    cases::add_face(mesh, {-0.1F, -0.1F, 2}, {0, 0.1F, 2}, {0.1F, -0.1F, 2});
    mesh.texcoords = {{0.25F, 0.25F}, {0.5F, 0.75F}, {0.75F, 0.25F}};
    const auto result = shaded(mesh, cases::straight(10, 10, 5), 0);
    CHECK(result.counts.valid == 100);
    for (std::size_t i = 0; i < 100; ++i)
    {
        CHECK(result.map.uv.values[2 * i] >= 0.25F);
        CHECK(result.map.uv.values[2 * i] <= 0.75F);
        CHECK(result.map.uv.values[2 * i + 1] >= 0.25F);
        CHECK(result.map.uv.values[2 * i + 1] <= 0.75F);
        CHECK(result.map.depth.values[i] == Approx(2));
    }
}

TEST_CASE("a face without area, or seen from its own plane, gives finite values or none")
{
    Mesh mesh;
    cases::add_face(mesh, {0, 0, 2}, {0, 0, 2}, {0, 0, 2});
    cases::add_face(mesh, {0, -1, 1}, {0, 1, 1}, {0, 0, 2});
    for (const std::uint32_t face : {0U, 1U})
    {
        const auto result = shaded(mesh, cases::straight(9, 9, 5), face);
        for (std::size_t i = 0; i < 81; ++i)
        {
            CHECK(std::isfinite(result.met.values[i]));
            CHECK(std::isfinite(result.map.depth.values[i]));
            CHECK(std::isfinite(result.map.cosine.values[i]));
            CHECK(std::isfinite(result.map.uv.values[2 * i]));
        }
    }
}

TEST_CASE("pixels without a face are cleared")
{
    const auto result = shaded(cases::wall(), cases::straight(4, 4, 5), no_face);
    CHECK(result.counts.nothing == 16);
    CHECK(result.map.uv.values == std::vector<float>(32, 0));
    CHECK(result.map.valid.values == std::vector<std::uint8_t>(16, 0));
    CHECK(std::isinf(result.met.values[0]));
}

TEST_CASE("only valid pixels are taken for cracks, and the count is theirs")
{
    UvMap map{RasterF(5, 3, 2, 0.5F), RasterF(5, 3, 1, 1), RasterF(5, 3, 1, 1), Raster8(5, 3, 1, 1)};
    RasterF met(5, 3, 1, 1);
    met.at(1, 1) = met.at(3, 1) = 2;
    map.valid.at(3, 1) = 0;  // the back of a face
    CHECK(FaceShader::close_cracks(met, 0, 1, map) == 0);
    CHECK(FaceShader::close_cracks(met, 1, 2, map) == 1);
    CHECK(map.valid.at(1, 1) == 0);
    CHECK(map.uv.at(1, 1, 1) == 0);
    CHECK(map.valid.at(2, 1) == 1);
}

TEST_CASE("points come back to the ray that meets them though the pose is no exact rotation")
{
    Camera camera = cases::turned(cases::straight(640, 480, 525), 0.7);
    camera.world_from_camera.rotation(1, 2) += 3e-4;
    camera.world_from_camera.translation = {1, 2, 3};
    const IntoCamera into_camera(camera.world_from_camera);
    const Vec3d ray = camera.ray(600, 400);
    CHECK(dot(into_camera.depth_axis(), ray) == Approx(1).epsilon(1e-12));
    const Vec3d p = into_camera.point(vec_cast<float>(camera.world_from_camera.translation + ray * 4.0));
    CHECK(525 * p.x / p.z + 320 == Approx(600).margin(1e-3));
    CHECK(525 * p.y / p.z + 240 == Approx(400).margin(1e-3));
    CHECK(p.z == Approx(4).epsilon(1e-6));
}

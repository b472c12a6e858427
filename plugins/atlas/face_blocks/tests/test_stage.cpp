#include "catch.h"

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>

using namespace fresco;

namespace
{

/// A row of triangles.
Mesh strip(std::uint32_t faces)
{
    Mesh mesh;
    for (std::uint32_t i = 0; i < faces + 2; ++i)
        mesh.positions.push_back({static_cast<float>(i), static_cast<float>(i % 2), 0});
    for (std::uint32_t i = 0; i < faces; ++i)
        mesh.triangles.push_back({i, i + 1, i + 2});
    return mesh;
}

std::shared_ptr<Mesh> run(const Mesh& mesh, const Value& options, testing::TestRun& context)
{
    const testing::TemporaryFolder folder;
    testing::run_stage(FRESCO_PLUGIN_FILE, "atlas.face_blocks", options, {{"mesh", std::make_shared<Mesh>(mesh)}}, folder.path(),
                       context);
    return Mesh::load({folder.path() / "atlas", {}});
}

}  // namespace

TEST_CASE("lookups in a face read only texels of its own block")
{
    testing::TestRun context;
    const auto uv = run(strip(256), Value::Map{{"size_px", 64}}, context)->texcoords;
    for (const std::size_t face : {0U, 17U, 255U})
        for (std::size_t corner = 3 * face; corner < 3 * face + 3; ++corner)
            // Between the corners lookups lie between theirs.
            for (const float noise : {-1.0F / 32, 1.0F / 32})
            {
                const auto column = std::floor(uv[corner].x * 64 - 0.5F + noise),
                           row = std::floor(uv[corner].y * 64 - 0.5F + noise);
                const auto left = static_cast<float>(4 * (face % 16)), bottom = static_cast<float>(4 * (face / 16));
                CHECK((column >= left && column + 1 <= left + 3));
                CHECK((row >= bottom && row + 1 <= bottom + 3));
            }
}

TEST_CASE("the stage gives every face a chart and counter-clockwise texture coordinates")
{
    testing::TestRun context;
    const auto atlas = run(strip(200), Value::Map{{"size_px", 64}}, context);
    CHECK(atlas->texture_px == 64);
    REQUIRE(atlas->texcoords.size() == 600);
    REQUIRE(atlas->charts.size() == 200);
    CHECK(atlas->charts[199] == 199);
    CHECK_NOTHROW(check_mesh(*atlas, "atlas"));
    for (std::size_t face = 0; face < 200; ++face)
    {
        const auto* uv = &atlas->texcoords[3 * face];
        const float area = (uv[1].x - uv[0].x) * (uv[2].y - uv[0].y) - (uv[2].x - uv[0].x) * (uv[1].y - uv[0].y);
        CHECK(area == Approx(2.875 * 2.875 / (64 * 64)));
    }
    CHECK(context.reported.find("used_share")->as_double() == Approx(200.0 / 256));
}

TEST_CASE("more faces than blocks are refused with the size that would do")
{
    testing::TestRun context;
    CHECK_THROWS_WITH(run(strip(257), Value::Map{{"size_px", 64}}, context),
                      Catch::Contains("room for 256") && Catch::Contains("to 128"));
}

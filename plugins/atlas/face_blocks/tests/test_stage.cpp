#include "catch.h"
#include "plugin_under_test.h"

#include <fresco/error.h>
#include <fresco/mesh.h>

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

std::shared_ptr<Mesh> blocks(const Mesh& mesh, const Value& options, testing::TestRun& run)
{
    return testing::output_of<Mesh>("atlas.face_blocks", "atlas", options, {{"mesh", std::make_shared<Mesh>(mesh)}}, run);
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "lookups in a face read only texels of its own block")
{
    const auto uv = blocks(strip(256), Value::Map{{"size_px", 64}}, run)->texcoords;
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

TEST_CASE_METHOD(testing::StageTest, "the stage gives every face a chart and counter-clockwise texture coordinates")
{
    const auto atlas = blocks(strip(200), Value::Map{{"size_px", 64}}, run);
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
    CHECK(run.reported.find("used_share")->as_double() == Approx(200.0 / 256));
}

TEST_CASE_METHOD(testing::StageTest, "more faces than blocks are refused with the size that would do")
{
    CHECK_THROWS_WITH(blocks(strip(257), Value::Map{{"size_px", 64}}, run),
                      Catch::Contains("room for 256") && Catch::Contains("to 128"));
}

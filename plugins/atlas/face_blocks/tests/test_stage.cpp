#include "catch.h"
#include "face_blocks.h"

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace fresco::face_blocks;

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

TEST_CASE("the corners of the first and of a later face by hand")
{
    const auto uv = texcoords(6, {16, 4});
    REQUIRE(uv.size() == 18);
    CHECK(uv[0].x == 0.5625F / 16);
    CHECK(uv[0].y == 0.5625F / 16);
    CHECK(uv[1].x == 3.4375F / 16);
    CHECK(uv[1].y == 0.5625F / 16);
    CHECK(uv[2].x == 0.5625F / 16);
    CHECK(uv[2].y == 3.4375F / 16);
    // Face 5 is the second of the second row.
    CHECK(uv[15].x == 4.5625F / 16);
    CHECK(uv[15].y == 4.5625F / 16);
}

TEST_CASE("lookups in a face read only texels of its own block, all of them but the far corner")
{
    const Layout layout{64, 4};
    const auto uv = texcoords(layout.blocks_count(), layout);
    for (const std::size_t face : {std::size_t{0}, std::size_t{17}, layout.blocks_count() - 1})
    {
        std::vector<int> touched(16);
        for (int a = 0; a <= 40; ++a)
            for (int b = 0; a + b <= 40; ++b)
            {
                const auto w1 = static_cast<float>(a) / 40;
                const auto w2 = static_cast<float>(b) / 40;
                const Vec2f* corner = &uv[3 * face];
                for (const float noise : {0.0F, -1.0F / 32, 1.0F / 32})
                {
                    const float x = (corner[0].x * (1 - w1 - w2) + corner[1].x * w1 + corner[2].x * w2) * 64 - 0.5F + noise;
                    const float y = (corner[0].y * (1 - w1 - w2) + corner[1].y * w1 + corner[2].y * w2) * 64 - 0.5F + noise;
                    for (const float column : {std::floor(x), std::floor(x) + 1})
                        for (const float row : {std::floor(y), std::floor(y) + 1})
                        {
                            const float weight = (1 - std::abs(x - column)) * (1 - std::abs(y - row));
                            if (weight <= 0)
                                continue;
                            const auto block = static_cast<std::size_t>(std::floor(row / 4)) * 16 +
                                               static_cast<std::size_t>(std::floor(column / 4));
                            REQUIRE(block == face);
                            touched[static_cast<std::size_t>(row) % 4 * 4 + static_cast<std::size_t>(column) % 4] +=
                                noise == 0 ? 1 : 0;
                        }
                }
            }
        // Texels from the anti-diagonal's second neighbor on lie outside the triangle.
        CHECK(std::count(touched.begin(), touched.end(), 0) == 3);
        CHECK(touched[15] == 0);
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
    CHECK(atlas->positions.size() == 202);
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
    CHECK(smallest_size_px(1'048'576, 4) == 4096);
    CHECK(smallest_size_px(1'048'577, 4) == 8192);
}

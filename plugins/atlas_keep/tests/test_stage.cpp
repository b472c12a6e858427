#include "catch.h"
#include "uv_charts.h"

#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

using fresco::Mesh;

namespace
{

/// A unit square of two faces; the uv are half the coordinates, so it covers a quarter of the atlas.
Mesh square()
{
    Mesh mesh = fresco::testing::rectangle({}, {1, 0, 0}, {0, 1, 0});
    fresco::testing::set_texcoords(mesh, [](fresco::Vec3f p) { return fresco::Vec2f{p.x * 0.5F, p.y * 0.5F}; });
    return mesh;
}

std::shared_ptr<Mesh> keep(const Mesh& mesh, fresco::testing::TestRun& run)
{
    fresco::testing::TemporaryFolder folder;
    fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "atlas.keep", fresco::Value::Map{}, {{"mesh", std::make_shared<Mesh>(mesh)}},
                               folder.path(), run);
    return Mesh::load({folder.path() / "atlas", {}});
}

}  // namespace

TEST_CASE("texcoords stay as they are; faces joined in uv are one chart")
{
    fresco::testing::TestRun run;
    const auto mesh = square();
    const auto out = keep(mesh, run);
    CHECK(out->texcoords == mesh.texcoords);
    CHECK(out->charts == std::vector<std::uint32_t>{0, 0});
    CHECK(out->texture_px == 2048);
    CHECK(run.reported.at("charts").as_int() == 1);
    CHECK(run.reported.at("used_share").as_double() == Approx(0.25));
    CHECK(run.reported.at("overlap_share").as_double() == 0);
    CHECK(run.messages.empty());
}

TEST_CASE("a seam in uv parts charts; faces on each other are reported as a share of the area")
{
    fresco::testing::TestRun run;
    auto mesh = square();
    // The second face moves onto the first, by half its width: both overlap. A third stays free.
    for (std::size_t c = 3; c < 6; ++c)
        mesh.texcoords[c] = mesh.texcoords[c] + fresco::Vec2f{0.25F, 0};
    mesh.positions.push_back({5, 5, 5});
    mesh.triangles.push_back({1, 0, 4});
    mesh.texcoords.insert(mesh.texcoords.end(), {{0.5F, 0.6F}, {1.0F, 0.6F}, {1.0F, 1.0F}});
    const auto out = keep(mesh, run);
    CHECK(out->charts == std::vector<std::uint32_t>{0, 1, 2});
    CHECK(run.reported.at("overlap_share").as_double() == Approx(0.25 / 0.35));
    REQUIRE(run.messages.size() == 1);
    CHECK(run.messages[0].find("71.4 %") != std::string::npos);
}

TEST_CASE("mirrored faces are counted by area")
{
    auto mesh = square();
    for (auto& uv : mesh.texcoords)
        uv.x = 0.5F - uv.x;
    CHECK(measure_uv(mesh, 1e-6).mirrored_share == Approx(1));
    CHECK(measure_uv(square(), 1e-6).mirrored_share == 0);
}

TEST_CASE("missing texcoords and tiles are refused with advice")
{
    fresco::testing::TestRun run;
    auto mesh = square();
    mesh.texcoords[4].x = 1.5F;
    CHECK_THROWS_WITH(keep(mesh, run), Catch::Contains("face 1") && Catch::Contains("atlas.project"));
    mesh.texcoords.clear();
    CHECK_THROWS_WITH(keep(mesh, run), Catch::Contains("no texture coordinates") && Catch::Contains("atlas.project"));
}

#include "known_atlases.h"

#include <fresco/testing_scenes.h>

using namespace fresco;

namespace
{

/// A unit square of two faces; the uv are half the coordinates, so it covers a quarter of the atlas.
Mesh square()
{
    Mesh mesh = testing::rectangle({}, {1, 0, 0}, {0, 1, 0});
    testing::set_texcoords(mesh, [](Vec3f p) { return Vec2f{p.x * 0.5F, p.y * 0.5F}; });
    return mesh;
}

}  // namespace

TEST_CASE("texcoords stay as they are; faces joined in uv are one chart")
{
    auto mesh = square();
    for (Vec2f& uv : mesh.texcoords)
        uv.x -= 1e-6F;
    const MadeAtlas made("atlas.model", mesh);
    CHECK(made.mesh->texcoords == mesh.texcoords);
    CHECK(made.mesh->charts == std::vector<std::uint32_t>{0, 0});
    CHECK(made.mesh->texture_px == 2048);
    CHECK(made.reported("charts") == 1);
    CHECK(made.reported("used_share") == Approx(0.25));
    CHECK(made.reported("overlap_share") + made.reported("mirrored_share") == 0);
    CHECK(made.run.messages.empty());
}

TEST_CASE("a seam in uv parts charts; faces on each other are reported as a share of the area")
{
    auto mesh = square();
    // The second face moves onto the first, by half its width: both overlap. A third stays free, mirrored.
    for (std::size_t c = 3; c < 6; ++c)
        mesh.texcoords[c] = mesh.texcoords[c] + Vec2f{0.25F, 0};
    mesh.positions.push_back({5, 5, 5});
    mesh.triangles.push_back({1, 0, 4});
    mesh.texcoords.insert(mesh.texcoords.end(), {{0.5F, 0.6F}, {1.0F, 1.0F}, {1.0F, 0.6F}});
    const MadeAtlas made("atlas.model", mesh, Value::Map{{"uvs", "keep"}});
    CHECK(made.mesh->charts == std::vector<std::uint32_t>{0, 1, 2});
    CHECK(made.reported("overlap_share") == Approx(0.25 / 0.35));
    CHECK(made.reported("mirrored_share") == Approx(0.1 / 0.35));
    REQUIRE(made.run.messages.size() == 1);
    CHECK(made.run.messages[0].find("71.4 %") != std::string::npos);
    // Left to itself, the stage makes new ones for the same faces.
    const MadeAtlas second("atlas.model", mesh);
    CHECK(second.mesh->triangles == mesh.triangles);
    CHECK(second.mesh->texcoords != mesh.texcoords);
    CHECK(check_atlas(*second.mesh, 2048, 4).none());
    CHECK_THAT(second.run.messages.at(0), Catch::Contains("71.4 %"));
    CHECK_FALSE(second.run.reported.at("kept").as_bool());
}

TEST_CASE("second and new replace texcoords that would serve, new on the simplified mesh")
{
    const auto mesh = square();
    const MadeAtlas second("atlas.model", mesh, Value::Map{{"uvs", "second"}});
    CHECK(second.mesh->texcoords != mesh.texcoords);
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    testing::run_stage(FRESCO_PLUGIN_FILE, "atlas.model", Value::Map{{"uvs", "new"}},
                       {{"mesh", std::make_shared<Mesh>(mesh)}, {"simplified", std::make_shared<Mesh>(testing::wall())}},
                       folder.path(), run);
    CHECK(Mesh::load({folder.path() / "atlas", {}})->positions == testing::wall().positions);
}

TEST_CASE("missing texcoords and tiles are refused with advice where they must be kept")
{
    auto mesh = square();
    const Value keep = Value::Map{{"uvs", "keep"}};
    mesh.texcoords[4].x = 1.5F;
    CHECK_THROWS_WITH(MadeAtlas("atlas.model", mesh, keep), Catch::Contains("face 1") && Catch::Contains("uvs: second"));
    mesh.texcoords.clear();
    CHECK_THROWS_WITH(MadeAtlas("atlas.model", mesh, keep), Catch::Contains("no texture coordinates"));
    // A face without area in the texture has no paint.
    mesh = square();
    std::fill_n(mesh.texcoords.begin(), 3, Vec2f{});
    CHECK_THAT(MadeAtlas("atlas.model", mesh).run.messages.at(0), Catch::Contains("50.0 % of the surface has no place"));
}

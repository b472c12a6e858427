#include "catch.h"
#include "shapes.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <set>

using namespace fresco;

namespace
{

/// Two squares of 1 m, one at half the scale of the other, in two corners of the texture.
Mesh two_squares()
{
    auto mesh = shapes::grid(1, [](float, float) { return 0.0F; });
    shapes::append(mesh, shapes::grid(1, [](float, float) { return 1.0F; }));
    for (std::size_t f = 0; f < 4; ++f)
        for (const auto v : mesh.triangles[f])
        {
            const auto& p = mesh.positions[v];
            mesh.texcoords.push_back(f < 2 ? Vec2f{p.x * 0.5F, p.y * 0.5F} : Vec2f{0.75F + p.x * 0.25F, 0.75F + p.y * 0.25F});
        }
    mesh.texture_px = 1000;
    return mesh;
}

void run_on(const Mesh& mesh, const Value& options, const std::filesystem::path& folder, testing::TestRun& run)
{
    testing::run_stage(FRESCO_PLUGIN_FILE, "render.atlas", options, {{"mesh", std::make_shared<Mesh>(mesh)}}, folder, run,
                       {{"image_io", std::make_shared<stored_png::Codec>()}});
}

}  // namespace

TEST_CASE("the picture shows both charts where they lie, the report what they are worth")
{
    testing::TemporaryFolder folder;
    testing::TestRun run;
    run_on(two_squares(), Value::Map{{"picture_px", 64}, {"path", "pictures/charts.png"}}, folder.path(), run);
    const auto files = Files::load({folder.path() / "picture", {}});
    REQUIRE(files->names == std::vector<std::string>{"pictures/charts.png"});

    const auto picture = stored_png::Codec().read_rgb(folder.path() / "picture" / files->names.front());
    REQUIRE(picture.width == 64);
    REQUIRE(picture.height == 64);
    const auto color = [&](int x, int y) { return std::array{picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2)}; };
    CHECK(color(1, 62) == color(30, 34));  // the large one, lower left
    CHECK(color(49, 1) == color(62, 14));  // the small one, upper right
    CHECK(std::set{color(1, 62), color(49, 1), color(1, 1)}.size() == 3);
    CHECK(color(34, 62) == color(1, 1));

    CHECK(run.reported.at("charts").as_int() == 2);
    CHECK(run.reported.at("used_share").as_double() == Approx(0.25 + 0.0625));
    CHECK(run.reported.at("seam_length_m").as_double() == 0);
    // Densities 1/2 and 1/4 of the texture a meter, on equal areas.
    CHECK(run.reported.at("density_variation").as_double() == Approx(0.125 / 0.375));
    CHECK(run.reported.at("texels_per_cm").as_double() == Approx(10 * std::sqrt((0.25 + 0.0625) / 2)));
}

TEST_CASE("a mesh without an atlas is refused")
{
    testing::TemporaryFolder folder;
    testing::TestRun run;
    auto mesh = two_squares();
    mesh.texcoords.assign(mesh.texcoords.size(), {0.5F, 0.5F});
    CHECK_THROWS_WITH(run_on(mesh, Value::Map{}, folder.path(), run), Catch::Contains("no area"));
    mesh.texcoords.clear();
    CHECK_THROWS_WITH(run_on(mesh, Value::Map{}, folder.path(), run), Catch::Contains("atlas.*"));
}

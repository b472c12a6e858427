#include "catch.h"
#include "shapes.h"

#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/regions/regions.h>
#include <fresco/testing.h>

using namespace fresco;

namespace
{

constexpr std::uint32_t squares = 8;

Mesh square(float z = 0)
{
    return shapes::grid(squares, [z](float, float) { return z; });
}

/// An ASCII PLY of the square whose left half is labeled 2 (floor), and the right one 1 (wall).
std::string labels()
{
    const Mesh mesh = square();
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.positions.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\nproperty ushort label\nelement face " +
                       std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3f& p : mesh.positions)
        text += std::to_string(p.x) + " " + std::to_string(p.y) + " 0 " + (p.x < 0.49F ? "2" : "1") + "\n";
    for (const auto& [a, b, c] : mesh.triangles)
        text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
    return text;
}

std::shared_ptr<Regions> divided(const Value& options, const testing::Inputs& inputs, testing::TestRun& run)
{
    testing::TemporaryFolder out;
    testing::run_stage(FRESCO_PLUGIN_FILE, "regions.labels", options, inputs, out.path(), run);
    return Regions::load({out.path() / "regions", out.path()});
}

}  // namespace

TEST_CASE("regions.labels: labels of a PLY reach a mesh that was made from it", "[regions.labels]")
{
    const testing::TemporaryFolder folder;
    write_file(folder.path() / "a.labels.ply", labels());
    const Value options = Value::Map{{"path", (folder.path() / "a.labels.ply").string()}};
    const auto finer = std::make_shared<Mesh>(shapes::grid(3 * squares, [](float, float) { return 0.01F; }));
    testing::TestRun run;
    const auto regions = divided(options, {{"mesh", finer}}, run);
    CHECK(run.reported.at("covered_share").as_double() == Approx(1));
    CHECK(run.reported.at("mean_distance_m").as_double() == Approx(0.01));
    REQUIRE(regions->label_of_face.size() == finer->triangles.size());
    for (std::size_t f = 0; f < regions->label_of_face.size(); ++f)
    {
        const auto& [a, b, c] = finer->triangles[f];
        const float x = (finer->positions[a].x + finer->positions[b].x + finer->positions[c].x) / 3;
        const std::string& name = regions->names[regions->label_of_face[f]];
        if (x < 0.37F || x > 0.5F)
            CHECK(name == (x < 0.45F ? "floor" : "wall"));
    }
}

TEST_CASE("regions.labels: labels of another mesh are refused by how much they cover", "[regions.labels]")
{
    const testing::TemporaryFolder folder;
    write_file(folder.path() / "a.labels.ply", labels());
    const std::string file = (folder.path() / "a.labels.ply").string();
    testing::TestRun run;
    Mesh mesh = square();
    for (Vec3f& p : mesh.positions)
        p.z = p.y > 0.24F ? 1.0F : 0.0F;
    CHECK_THROWS_WITH(
        divided(Value::Map{{"path", file}}, {{"mesh", std::make_shared<Mesh>(mesh)}}, run),
        Catch::Contains("% of the mesh on port 'mesh' is within 5 cm of the labeled faces; expected at least 80%: these "
                        "are labels of another mesh"));
    // A mesh that lies elsewhere says where its vertices are.
    const auto moved = std::make_shared<Mesh>(square(5));
    const auto regions = divided(Value::Map{{"path", file}}, {{"mesh", moved}, {"labeled", moved}}, run);
    CHECK(regions->names == std::vector<std::string>{"floor", "wall"});
}

TEST_CASE("regions.labels: materials of a model, ScanNet's segments, and what they need", "[regions.labels]")
{
    testing::TestRun run;
    const auto mesh = std::make_shared<Mesh>(square());
    Model model;
    model.mesh = *mesh;
    model.materials.resize(1);
    model.materials[0].name = "carpet";
    model.material_of_face.assign(mesh->triangles.size(), 0);
    const testing::Inputs with_model{{"mesh", mesh}, {"model", std::make_shared<Model>(model)}};
    CHECK(divided(Value::Map{}, with_model, run)->names == std::vector<std::string>{"carpet"});

    const testing::TemporaryFolder folder;
    const std::string groups = (folder.path() / "a.aggregation.json").string();
    const std::string segments = (folder.path() / "a.segs.json").string();
    write_file(groups, R"({"segGroups": [{"label": "rug", "segments": [3]}]})");
    std::string indices;
    for (std::size_t v = 0; v < mesh->positions.size(); ++v)
        indices += v == 0 ? "3" : ", 3";
    write_file(segments, R"({"segIndices": [)" + indices + "]}");
    const Value both = Value::Map{{"path", groups}, {"segments", segments}};
    CHECK(divided(both, {{"mesh", mesh}, {"labeled", mesh}}, run)->names == std::vector<std::string>{"rug"});

    CHECK_THROWS_WITH(divided(both, {{"mesh", mesh}}, run),
                      Catch::Contains("wire the mesh that both are for to the input 'labeled'"));
    CHECK_THROWS_WITH(divided(Value::Map{{"path", groups}}, {{"mesh", mesh}, {"labeled", mesh}}, run),
                      Catch::Contains("set 'segments' to the scene's .segs.json"));
    CHECK_THROWS_WITH(divided(Value::Map{}, {{"mesh", mesh}}, run),
                      Catch::Contains("set either 'path' to a file with labels, or the "
                                      "input 'model'"));
    CHECK_THROWS_WITH(divided(both, with_model, run), Catch::Contains("set either 'path'"));
}

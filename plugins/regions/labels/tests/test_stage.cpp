#include "catch.h"
#include "labeled_surface.h"
#include "plugin_under_test.h"
#include "shapes.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/geometry/surface_search.h>
#include <fresco/mesh.h>
#include <fresco/random.h>
#include <fresco/regions/regions.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>
#include <span>

using namespace fresco;

namespace
{

/// The mesh with a property of its vertices or of its faces, a digit each.
std::string ply(const std::string& of_vertex, const std::string& of_face, const std::string& type = "ushort",
                const Mesh& mesh = shapes::grid(1, [](float, float) { return 0.0F; }))
{
    const std::string property = "property " + type + " label\n";
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.positions.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
                       "property uchar blue\nproperty uchar alpha\n" +
                       (of_vertex.empty() ? "" : property) + "element face " + std::to_string(mesh.triangles.size()) +
                       "\nproperty list uchar int vertex_indices\n" + (of_face.empty() ? "" : property) + "end_header\n";
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        text += fmt::format("{} {} {} 9 9 9 255 {}\n", mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z,
                            of_vertex.empty() ? "" : of_vertex.substr(v, 1));
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        text += fmt::format("3 {} {}\n", fmt::join(mesh.triangles[f], " "), of_face.empty() ? "" : of_face.substr(f, 1));
    return text;
}

LabeledSurface read(const std::string& text, Naming naming = Naming::nyu40, const Mesh* moved = nullptr,
                    const std::string& property = "label")
{
    return surface_from_ply(std::as_bytes(std::span(text)), "a.ply", property, naming, moved);
}

std::string name_of(const LabeledSurface& surface, std::size_t face)
{
    return surface.label_of_face[face] == no_label ? "" : surface.names[surface.label_of_face[face]];
}

}  // namespace

TEST_CASE("labels of a PLY: vertices vote for their faces, by NYU40's names or numbers")
{
    const LabeledSurface scannet = read(ply("1212", ""));
    CHECK(name_of(scannet, 0) == "wall");
    CHECK(name_of(scannet, 1) == "floor");
    const LabeledSurface partly = read(ply("0025", ""));
    CHECK(name_of(partly, 0).empty());
    CHECK(name_of(partly, 1).empty());
    CHECK(name_of(read(ply("0725", ""), Naming::numbers), 0) == "0");
    const LabeledSurface faces = read(ply("", "35"), Naming::numbers);
    CHECK(name_of(faces, 0) == "3");
    CHECK(name_of(faces, 1) == "5");
    CHECK(name_of(read(ply("", "52")), 0) == "chair");
    // A property that means something to a mesh, too.
    CHECK(read(ply("", "52"), Naming::numbers, nullptr, "red").names == std::vector<std::string>{"9"});
}

TEST_CASE("labels of a PLY: another property, floats, nothing labeled and another mesh are refused")
{
    CHECK_THROWS_WITH(read(ply("1111", ""), Naming::nyu40, nullptr, "labels"),
                      Contains("a.ply") && Contains("(did you mean 'label'?)"));
    CHECK_THROWS_WITH(read(ply("1111", "", "float")), Contains("an integer property 'label'"));
    CHECK_THROWS_WITH(read(ply("0000", "")), Contains("labels nothing") && Contains("naming: numbers"));
    Mesh other;
    other.positions.resize(3);
    CHECK_THROWS_WITH(read(ply("1111", ""), Naming::nyu40, &other),
                      Contains("a.ply has 4 vertices, the mesh on port 'labeled' 3"));
    other.positions.assign(4, Vec3f{7, 8, 9});
    CHECK(read(ply("1111", ""), Naming::nyu40, &other).mesh.positions[2] == Vec3f{7, 8, 9});
}

TEST_CASE("labels of ScanNet's and Matterport3D's segmentations: objects name segments, segments hold vertices or faces")
{
    const std::string text = ply("1111", "");
    const Mesh mesh = read(text).mesh;
    const std::string groups = R"({"sceneId": "s", "segGroups": [{"id": 0, "label": "office chair", "segments": [7]},
        {"id": 1, "label": "floor", "segments": [2, 3]}, {"id": 2, "label": "office chair", "segments": [9]}]})";
    const auto labeled = [&](const std::string& segments)
    { return surface_from_segments(groups, "a.aggregation.json", R"({"segIndices": )" + segments + "}", "a.segs.json", mesh); };
    const LabeledSurface surface = labeled("[7, 9, 7, 2]");
    CHECK(surface.names == std::vector<std::string>{"office chair", "floor"});
    CHECK(name_of(surface, 0) == "office chair");
    CHECK(name_of(surface, 1) == "office chair");
    CHECK(name_of(labeled("[4, 4, 2, 2]"), 0).empty());
    CHECK_THROWS_WITH(labeled("[7, 9, 7]"),
                      Contains("a.segs.json has the segments of 3 vertices, the mesh on port 'labeled' has 4"));
    CHECK_THROWS_WITH(labeled("[4, 4, 4, 4]"), Contains("a.aggregation.json names none of the segments of a.segs.json"));
    CHECK_THROWS_WITH(labeled("[4"), Contains("a.segs.json"));
    // Matterport3D's are those of faces.
    const auto of_faces = [&](const std::string& segments)
    { return surface_from_segments(groups, "a.semseg.json", R"({"segIndices": )" + segments + "}", "a.fsegs.json", mesh); };
    CHECK(name_of(of_faces("[2, 9]"), 0) == "floor");
    CHECK(name_of(of_faces("[2, 9]"), 1) == "office chair");
    CHECK_THROWS_WITH(of_faces("[7, 9, 7, 2]"),
                      Contains("a.fsegs.json has the segments of 4 faces, the mesh on port 'labeled' has 2"));
}

namespace
{

/// A bumpy square of 1 m whose faces are labeled by random.
LabeledSurface bumpy(std::uint32_t squares)
{
    LabeledSurface surface;
    surface.mesh = shapes::grid(squares, [](float x, float y) { return 0.1F * std::sin(7 * x) * std::cos(5 * y); });
    surface.names = {"a", "b", "c"};
    Random random(9);
    for (std::size_t f = 0; f < surface.mesh.triangles.size(); ++f)
    {
        const auto label = static_cast<std::uint32_t>(random.uniform() * 4);
        surface.label_of_face.push_back(label == 3 ? no_label : label);
    }
    return surface;
}

}  // namespace

TEST_CASE("carried labels: those of the closest face, as a look at every face finds it")
{
    const LabeledSurface from = bumpy(13);
    Mesh to = bumpy(20).mesh;
    Random random(4);
    for (Vec3f& p : to.positions)
        p.z += static_cast<float>(0.06 * random.uniform());
    constexpr double within_m = 0.03;
    const CarriedLabels carried = carried_labels(from, to, within_m, Progress{});
    for (std::size_t f = 0; f < to.triangles.size(); ++f)
    {
        const auto corner = [](const Mesh& mesh, std::uint32_t v) { return vec_cast<double>(mesh.positions[v]); };
        const auto& [a, b, c] = to.triangles[f];
        const Vec3d middle = (corner(to, a) + corner(to, b) + corner(to, c)) * (1.0 / 3);
        std::vector<double> distances;
        for (const auto& [p, q, r] : from.mesh.triangles)
        {
            const std::array corners{corner(from.mesh, p), corner(from.mesh, q), corner(from.mesh, r)};
            const auto w = geometry::nearest_weights(corners, middle);
            distances.push_back(length(corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2] - middle));
        }
        const double least = *std::ranges::min_element(distances);
        // Several faces share a closest point on an edge.
        std::set<std::uint32_t> labels;
        for (std::size_t g = 0; g < distances.size(); ++g)
            if (distances[g] < least + 1e-9)
                labels.insert(from.label_of_face[g]);
        CHECK((least < within_m ? labels.contains(carried.label_of_face[f]) : carried.label_of_face[f] == no_label));
    }
    CHECK(carried.covered_share > 0.3);
    CHECK(carried.covered_share < 0.9);
}

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
    std::string of_vertex;
    for (const Vec3f& p : mesh.positions)
        of_vertex += p.x < 0.49F ? "2" : "1";
    return ply(of_vertex, "", "ushort", mesh);
}

std::shared_ptr<Regions> divided(const Value& options, const testing::Inputs& inputs, testing::TestRun& run)
{
    return testing::output_of<Regions>("regions.labels", "regions", options, inputs, run);
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "regions.labels: labels of a PLY reach a mesh that was made from it", "[regions.labels]")
{
    write_file(folder.path() / "a.labels.ply", labels());
    const Value options = Value::Map{{"path", (folder.path() / "a.labels.ply").string()}};
    const auto finer = std::make_shared<Mesh>(shapes::grid(3 * squares, [](float, float) { return 0.01F; }));
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
    // Stored less another offset than the labels' mesh.
    const auto moved = std::make_shared<Mesh>(*finer);
    moved->offset_m = {128, 0, -64};
    for (Vec3f& p : moved->positions)
        p = p - Vec3f{128, 0, -64};
    divided(options, {{"mesh", moved}}, run);
    CHECK(run.reported.at("covered_share").as_double() == Approx(1));
    CHECK(run.reported.at("mean_distance_m").as_double() == Approx(0.01).epsilon(1e-3));
}

TEST_CASE_METHOD(testing::StageTest, "regions.labels: faces without a label keep the regions that they had", "[regions.labels]")
{
    const auto mesh = std::make_shared<Mesh>(square());
    std::string half;
    for (const Vec3f& p : mesh->positions)
        half += p.x < 0.49F ? "2" : "0";
    write_file(folder.path() / "a.labels.ply", ply(half, "", "ushort", *mesh));
    const auto planes =
        std::make_shared<Regions>(regions_from(*mesh, {"walls", "floor"}, std::vector<std::uint32_t>(mesh->triangles.size(), 0)));
    const Value options = Value::Map{{"path", (folder.path() / "a.labels.ply").string()}};
    const auto regions = divided(options, {{"mesh", mesh}, {"regions", planes}}, run);
    CHECK(regions->names == std::vector<std::string>{"walls", "floor"});
    const auto count = std::ranges::count(regions->label_of_face, 1U);
    CHECK(count > 0);
    CHECK(count < static_cast<std::ptrdiff_t>(mesh->triangles.size()));
    CHECK(divided(options, {{"mesh", mesh}}, run)->names == std::vector<std::string>{"floor", "other"});
}

TEST_CASE_METHOD(testing::StageTest, "regions.labels: labels of another mesh are refused by how much they cover",
                 "[regions.labels]")
{
    write_file(folder.path() / "a.labels.ply", labels());
    const std::string file = (folder.path() / "a.labels.ply").string();
    Mesh mesh = square();
    for (Vec3f& p : mesh.positions)
        p.z = p.y > 0.24F ? 1.0F : 0.0F;
    CHECK_THROWS_WITH(divided(Value::Map{{"path", file}}, {{"mesh", std::make_shared<Mesh>(mesh)}}, run),
                      Contains("labels of another mesh"));
    // A mesh that lies elsewhere says where its vertices are.
    const auto moved = std::make_shared<Mesh>(square(5));
    const auto regions = divided(Value::Map{{"path", file}}, {{"mesh", moved}, {"labeled", moved}}, run);
    CHECK(regions->names == std::vector<std::string>{"floor", "wall"});
}

TEST_CASE_METHOD(testing::StageTest, "regions.labels: materials of a model, ScanNet's segments, and what they need",
                 "[regions.labels]")
{
    const auto mesh = std::make_shared<Mesh>(square());
    Model model;
    model.mesh = *mesh;
    model.materials.resize(1);
    model.materials[0].name = "carpet";
    model.material_of_face.assign(mesh->triangles.size(), 0);
    const testing::Inputs with_model{{"mesh", mesh}, {"model", std::make_shared<Model>(model)}};
    CHECK(divided(Value::Map{}, with_model, run)->names == std::vector<std::string>{"carpet"});
    model.materials[0].name.clear();
    CHECK_THROWS_WITH(surface_from_materials(model), Contains("no material of the model on port 'model' has a name"));

    const std::string groups = (folder.path() / "a.aggregation.json").string();
    const std::string segments = (folder.path() / "a.segs.json").string();
    write_file(groups, R"({"segGroups": [{"label": "rug", "segments": [3]}]})");
    std::string indices;
    for (std::size_t v = 0; v < mesh->positions.size(); ++v)
        indices += v == 0 ? "3" : ", 3";
    write_file(segments, R"({"segIndices": [)" + indices + "]}");
    const Value both = Value::Map{{"path", groups}, {"segments", segments}};
    CHECK(divided(both, {{"mesh", mesh}, {"labeled", mesh}}, run)->names == std::vector<std::string>{"rug"});

    CHECK_THROWS_WITH(divided(both, {{"mesh", mesh}}, run), Contains("to the input 'labeled'"));
    CHECK_THROWS_WITH(divided(Value::Map{{"path", groups}}, {{"mesh", mesh}, {"labeled", mesh}}, run),
                      Contains("set 'segments' to the scene's .segs.json or .fsegs.json"));
    CHECK_THROWS_WITH(divided(Value::Map{}, {{"mesh", mesh}}, run), Contains("set either 'path'"));
    CHECK_THROWS_WITH(divided(both, with_model, run), Contains("set either 'path'"));
    CHECK_THROWS_WITH(divided(Value::Map{{"masks", folder.path().string()}}, {{"mesh", mesh}}, run),
                      Contains("wire them to the input 'frames'"));

    // Objects of the mesh that the other was made from.
    const auto objects = std::make_shared<Regions>(
        regions_from(*mesh, {"chair", "house/table"}, std::vector<std::uint32_t>(mesh->triangles.size(), 1)));
    const auto finer = std::make_shared<Mesh>(shapes::grid(3 * squares, [](float, float) { return 0.01F; }));
    const testing::Inputs with_objects{{"mesh", finer}, {"labeled", mesh}, {"objects", objects}};
    CHECK(divided(Value::Map{}, with_objects, run)->names == std::vector<std::string>{"house/table"});
    CHECK_THROWS_WITH(divided(Value::Map{}, {{"mesh", finer}, {"objects", objects}}, run), Contains("to the input 'labeled'"));
    CHECK_THROWS_WITH(divided(Value::Map{}, {{"mesh", finer}, {"labeled", finer}, {"objects", objects}}, run),
                      Contains("the regions on port 'objects' are of another mesh"));

    // `input: STAGE` wires every port, whether the stage needs it or not.
    auto with_all = with_model;
    with_all["frames"] = std::make_shared<Frames>();
    with_all["regions"] =
        std::make_shared<Regions>(regions_from(*mesh, {"walls"}, std::vector<std::uint32_t>(mesh->triangles.size(), 0)));
    CHECK(divided(Value::Map{}, with_all, run)->names == std::vector<std::string>{"carpet"});
}

#include "catch.h"
#include "class_names.h"
#include "labeled_surface.h"

#include <fresco/error.h>

#include <span>

using namespace fresco;

namespace
{

/// Four vertices in a row of two faces, with a property of the vertices or of the faces.
std::string ply(const std::string& of_vertex, const std::string& of_face, const std::string& type = "ushort")
{
    const bool vertices = !of_vertex.empty();
    std::string text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                       "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    text += vertices ? "property " + type + " label\n" : "";
    text += "element face 2\nproperty list uchar int vertex_indices\n";
    text += vertices ? "" : "property " + type + " label\n";
    text += "end_header\n";
    for (int v = 0; v < 4; ++v)
        text += std::to_string(v % 2) + " " + std::to_string(v / 2) + " 0 9 9 9 255" +
                (vertices ? std::string(" ") + of_vertex[static_cast<std::size_t>(v)] : "") + "\n";
    const std::string faces[] = {"3 0 1 2", "3 1 3 2"};
    for (int f = 0; f < 2; ++f)
        text += faces[f] + (vertices ? "" : std::string(" ") + of_face[static_cast<std::size_t>(f)]) + "\n";
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
                      Catch::Contains("a.ply") &&
                          Catch::Contains("neither vertices nor faces have an integer property 'labels' (did "
                                          "you mean 'label'?)"));
    CHECK_THROWS_WITH(read(ply("1111", "", "float")),
                      Catch::Contains("neither vertices nor faces have an integer property 'label'"));
    CHECK_THROWS_WITH(read(ply("0000", "")),
                      Catch::Contains("the property 'label' labels nothing") && Catch::Contains("set naming: numbers"));
    Mesh other;
    other.positions.resize(3);
    CHECK_THROWS_WITH(read(ply("1111", ""), Naming::nyu40, &other),
                      Catch::Contains("a.ply has 4 vertices, the mesh on port 'labeled' 3: these are labels of another mesh"));
    other.positions.assign(4, Vec3f{7, 8, 9});
    CHECK(read(ply("1111", ""), Naming::nyu40, &other).mesh.positions[2] == Vec3f{7, 8, 9});
}

TEST_CASE("labels of ScanNet's segmentation: objects name segments, segments hold vertices")
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
                      Catch::Contains("a.segs.json has the segments of 3 vertices, the mesh on port 'labeled' "
                                      "has 4: these are labels of another mesh"));
    CHECK_THROWS_WITH(labeled("[4, 4, 4, 4]"), Catch::Contains("a.aggregation.json names none of the segments of a.segs.json"));
    CHECK_THROWS_WITH(labeled("[4"), Catch::Contains("a.segs.json"));
}

TEST_CASE("labels of a model: its materials' names")
{
    Model model;
    model.mesh = read(ply("1111", "")).mesh;
    model.materials.resize(3);
    model.materials[1].name = "Oak floor";
    model.material_of_face = {1, 2};
    const LabeledSurface surface = surface_from_materials(model);
    CHECK(surface.names == std::vector<std::string>{"Oak floor"});
    CHECK(name_of(surface, 0) == "Oak floor");
    CHECK(name_of(surface, 1).empty());
    model.materials[1].name.clear();
    CHECK_THROWS_WITH(surface_from_materials(model), Catch::Contains("no material of the model on port 'model' has a name"));
}

TEST_CASE("NYU40 has forty names")
{
    CHECK(nyu40_name(1) == "wall");
    CHECK(nyu40_name(2) == "floor");
    CHECK(nyu40_name(22) == "ceiling");
    CHECK(nyu40_name(40) == "otherprop");
    CHECK(!nyu40_name(0));
    CHECK(!nyu40_name(41));
}

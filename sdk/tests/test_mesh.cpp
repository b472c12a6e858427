#include "catch.h"
#include "ply_samples.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

using namespace fresco;
using testing::box;

TEST_CASE("Mesh: vertex normals are weighted by area", "[mesh]")
{
    // A floor triangle of area 2 and a wall triangle of area 0.5 share an edge; vertex 4 belongs to no face.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 4, 0}, {0, 0, 1}, {9, 9, 9}};
    mesh.triangles = {{0, 1, 2}, {0, 3, 1}};
    const auto normals = vertex_normals(mesh);
    REQUIRE(normals.size() == 5);
    CHECK(normals[2] == Vec3f{0, 0, 1});
    CHECK(normals[3] == Vec3f{0, 1, 0});
    const float norm = std::sqrt(17.0F);
    CHECK(normals[0].x == 0);
    CHECK(normals[0].y == Approx(1 / norm));
    CHECK(normals[0].z == Approx(4 / norm));
    CHECK(normals[1] == normals[0]);
    CHECK(normals[4] == Vec3f{0, 0, 0});
}

TEST_CASE("Mesh: degenerate faces have no normal, slivers have one", "[mesh]")
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1e-20F, 0, 1e-20F}};
    mesh.triangles = {{0, 1, 2}, {0, 0, 1}, {0, 1, 3}};
    const auto normals = face_normals(mesh);
    CHECK(normals[0] == Vec3f{0, 0, 0});
    CHECK(normals[1] == Vec3f{0, 0, 0});
    CHECK(normals[2] == Vec3f{0, -1, 0});
}

TEST_CASE("Mesh: check_mesh names the first offence", "[mesh]")
{
    const auto refused = [](auto&& damage, const std::string& reason)
    {
        Mesh mesh = box();
        mesh.texcoords.assign(36, {0.5F, 0.5F});
        mesh.colors.assign(8, {1, 2, 3});
        mesh.charts.assign(12, 0);
        CHECK_NOTHROW(check_mesh(mesh, "cube"));
        damage(mesh);
        CHECK_THROWS_WITH(check_mesh(mesh, "cube"), Contains("cube: ") && Contains(reason));
        CHECK_THROWS_AS(to_ply(mesh), Error);
    };
    refused([](Mesh& m) { m.triangles.clear(); }, "no faces");
    refused([](Mesh& m) { m.triangles[3][1] = 8; }, "face 3 names vertex 8 of 8");
    refused([](Mesh& m) { m.positions[2].z = std::numeric_limits<float>::infinity(); }, "vertex 2 is not finite");
    refused([](Mesh& m) { m.positions[7].x = std::nanf(""); }, "vertex 7 is not finite");
    refused([](Mesh& m) { m.positions[5].y = -1.1e7F; }, "vertex 5 is more than 1e7 m from the origin, at (");
    refused([](Mesh& m) { m.positions[0].x = 3e38F; }, "vertex 0 is more than 1e7 m from the origin, at (3e+38, ");
    refused([](Mesh& m) { std::ranges::for_each(m.positions, [](Vec3f& p) { p = p * 3e-5F; }); },
            "the faces have an area of 5.4e-09 m² in all; at least 1e-8 m²");
    refused([](Mesh& m) { std::ranges::for_each(m.positions, [](Vec3f& p) { p = p * 1e-45F; }); }, "the faces have an area of");
    refused([](Mesh& m) { std::ranges::for_each(m.positions, [](Vec3f& p) { p.x = p.y = 0; }); },
            "the faces have an area of 0 m²");
    refused([](Mesh& m) { m.texcoords[10].y = std::nanf(""); }, "corner 1 of face 3");
    refused([](Mesh& m) { m.texcoords.pop_back(); }, "35 texcoords; expected 36");
    refused([](Mesh& m) { m.colors.pop_back(); }, "7 colors; expected 8");
    refused([](Mesh& m) { m.charts.push_back(0); }, "13 charts; expected 12");
    for (const float scale : {1e7F, 1e-4F})
    {
        Mesh mesh = box();
        for (Vec3f& position : mesh.positions)
            position = position * scale;
        CHECK_NOTHROW(check_mesh(mesh, "cube"));
    }
}

TEST_CASE("Mesh: saved and loaded it is the same, faces that name a vertex twice included", "[mesh]")
{
    const testing::TemporaryFolder folder;
    Mesh mesh = box();
    mesh.triangles.push_back({3, 3, 5});
    mesh.texcoords.assign(39, {0.25F, 0.75F});
    for (std::uint32_t f = 0; f < 13; ++f)
        mesh.charts.push_back(f);
    mesh.save({folder.path(), {}});
    CHECK(same_mesh(*Mesh::load({folder.path(), {}}), mesh));
    const auto bytes = read_file(folder.path() / "mesh.ply");
    CHECK(parse_ply(bytes, "mesh.ply").triangles.size() == 12);
    // A wrong mesh does not replace it.
    CHECK_THROWS_AS(Mesh{}.save({folder.path(), {}}), Error);
    CHECK(read_file(folder.path() / "mesh.ply") == bytes);
    write_file(folder.path() / "mesh.ply", std::span(bytes).first(bytes.size() - 1));
    CHECK_THROWS_WITH(Mesh::load({folder.path(), {}}), Contains("mesh.ply"));
    std::filesystem::remove(folder.path() / "mesh.ply");
    CHECK_THROWS_AS(Mesh::load({folder.path(), {}}), MissingInput);
}

TEST_CASE("Mesh: coordinates that floats are too coarse for are stored less a rounded offset", "[mesh]")
{
    CHECK(offset_for({}) == Vec3d{});
    CHECK(offset_for(std::vector<Vec3d>{{1023, -1023, 0}, {1023, -1023, 1}, {9e6, 9e6, -9e6}}) == Vec3d{});
    // A room in millimeters is not far from 0.
    CHECK(offset_for(std::vector<Vec3d>{{0, 0, 0}, {1000, 5000, 0}, {4000, 5000, 0}, {4000, 6000, 0}}) == Vec3d{});
    // Its cameras, all at one height, are not, either.
    CHECK(offset_for(std::vector<Vec3d>{{0, 0, 1450}, {1000, 3000, 1500}, {4000, 0, 1500}, {4000, 3000, 1550}}) == Vec3d{});
    // Neither stray vertices nor a height take part.
    std::vector<Vec3d> strayed(8, {448'049, -5'411'051, 1000});
    strayed[2] = {0, 9e6, -9e6};
    CHECK(offset_for(strayed) == Vec3d{448'000, -5'411'100, 0});
    strayed[5] = {0, 0, 0};
    CHECK(offset_for(strayed) == Vec3d{});
    const std::vector<Vec3d> far{{448'001.234, -5'411'049.5, 112.25}, {448'003.5, -5'411'048, 112.5}, {448'002, -5'411'040, 112}};
    const Vec3d offset = offset_for(far);
    CHECK(offset == Vec3d{448'000, -5'411'000, 0});
    Mesh mesh;
    place(mesh, far, offset);
    mesh.triangles = {{0, 1, 2}};
    CHECK(mesh.positions[0] == Vec3f{1.234F, -49.5F, 112.25F});
    CHECK(world_positions(mesh) == far);

    const testing::TemporaryFolder folder;
    mesh.save({folder.path(), {}});
    const auto loaded = Mesh::load({folder.path(), {}});
    CHECK(same_mesh(*loaded, mesh));
    CHECK(loaded->offset_m == offset);
    testing::TestRun run;
    tell_offset(offset, run);
    tell_offset({}, run);
    REQUIRE(run.messages.size() == 1);
    CHECK_THAT(run.messages[0], Contains("(448000, -5411000, 0) m are taken off"));
    CHECK(run.reported.at("offset_m") == Value(Value::List{448'000.0, -5'411'000.0, 0.0}));

    // Without one, nothing is written, and all of float is kept.
    place(mesh, far, {});
    CHECK(world_positions(mesh)[0] == vec_cast<double>(mesh.positions[0]));
    const auto plain = to_ply(mesh);
    CHECK_THAT(std::string(reinterpret_cast<const char*>(plain.data()), 200), !Contains("offset_m"));
    mesh.offset_m.y = -5e6;
    CHECK_THROWS_WITH(check_mesh(mesh, "floor"),
                      Contains("vertex 0 is more than 1e7 m from the origin, at (448001, -1.0411e+07,"));
}

TEST_CASE("Mesh: files are read in double, whatever type they declare as text", "[mesh]")
{
    Mesh expected = folded_square();
    const std::string vertices = "448001.234 5411002.5 1 0 127 255\n448002.5 5411002.5 1.25 1 2 3\n"
                                 "448002.5 5411003.001 2 10 20 30\n448001.234 5411003.001 -1.5 255 0 7\n";
    const std::vector<Vec3d> exact{{448'001.234, 5'411'002.5, 1},
                                   {448'002.5, 5'411'002.5, 1.25},
                                   {448'002.5, 5'411'003.001, 2},
                                   {448'001.234, 5'411'003.001, -1.5}};
    const Vec3d offset{448'000, 5'411'000, 0};
    place(expected, exact, offset);
    const auto check = [&](const Mesh& mesh, const MeshReadReport& report)
    {
        CHECK(same_mesh(mesh, expected));
        CHECK(mesh.offset_m == offset);
        CHECK(report.positions == exact);
    };
    MeshReadReport report;
    for (const auto& [type, encoding] : {std::pair("float", all_encodings[0]),
                                         {"double", all_encodings[0]},
                                         {"double", all_encodings[1]},
                                         {"double", all_encodings[2]}})
    {
        INFO(encoding << ' ' << type);
        std::string text = ply_of(expected, "ascii", {.coordinate = type});
        text.replace(text.find("end_header\n") + 11, text.find("3 0 1 2") - text.find("end_header\n") - 11, vertices);
        const Mesh mesh = parse_ply(bytes_of(in_encoding(encoding, text)), "floor.ply", {}, &report);
        check(mesh, report);
    }
    std::string text;
    for (const Vec3d& p : exact)
        text += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
    expected.colors.clear();
    const Mesh mesh = parse_obj(bytes_of(text + "f 1 2 3\nf 1 3 4\n"), "floor.obj", {}, &report);
    check(mesh, report);
    // A mesh that was written less an offset is read with it.
    const Mesh again = parse_ply(to_ply(mesh), "floor.ply", {}, &report);
    CHECK(same_mesh(again, mesh));
    CHECK(again.offset_m == offset);
    CHECK_THROWS_WITH(parse_ply(bytes_of("ply\nformat ascii 1.0\ncomment offset_m 1 2 x\n"), "floor.ply"),
                      Contains("floor.ply:3: expected 'comment offset_m' and three numbers"));
}

TEST_CASE("Mesh: read_mesh goes by the extension", "[mesh]")
{
    const testing::TemporaryFolder folder;
    write_file(folder.path() / "cube.PLY", to_ply(box()));
    write_file(folder.path() / "triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n");
    write_file(folder.path() / "scan.stl", "solid\n");
    CHECK(same_mesh(read_mesh(folder.path() / "cube.PLY"), box()));
    MeshReadReport report;
    CHECK(read_mesh(folder.path() / "triangle.obj", {}, &report).triangles.size() == 2);
    CHECK(report.polygons_split == 1);
    CHECK_THROWS_WITH(read_mesh(folder.path() / "scan.stl"), Contains("scan.stl") && Contains(".ply or .obj"));
    CHECK_THROWS_AS(read_mesh(folder.path() / "missing.ply"), MissingInput);
}

namespace
{

Model two_materials()
{
    Model model;
    model.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    model.mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
    model.mesh.triangles = {{0, 1, 2}, {2, 1, 0}};
    model.mesh.texcoords = {{0, 0}, {-2, 0}, {0, 3.5F}, {0, 0}, {0, 0}, {0, 0}};
    model.materials = {{"wall", {0.1F, 0.2F, 1}, 0, Wrap::mirror, Wrap::clamp, false}, {"floor", {1, 1, 1}, -1, {}, {}, true}};
    model.material_of_face = {1, 0};
    model.pictures = {"picture_0.png"};
    return model;
}

void save(const Model& model, const std::filesystem::path& folder)
{
    for (const std::string& picture : model.pictures)
        write_file(folder / picture, "a picture");
    model.save({folder, folder});
}

}  // namespace

TEST_CASE("a model is loaded as it was saved, and says where its pictures are", "[model]")
{
    const testing::TemporaryFolder folder;
    const Model model = two_materials();
    save(model, folder.path());
    const auto loaded = Model::load({folder.path(), folder.path()});
    CHECK(same_mesh(loaded->mesh, model.mesh));
    CHECK(loaded->material_of_face == model.material_of_face);
    REQUIRE(loaded->materials.size() == 2);
    CHECK(loaded->materials[0].wrap_u == Wrap::mirror);
    CHECK(loaded->materials[1].vertex_colors);
    const std::string text = read_text_file(folder.path() / "model.json");
    save(*loaded, folder.path());
    CHECK(read_text_file(folder.path() / "model.json") == text);
    CHECK(std::filesystem::exists(loaded->loaded_from / loaded->pictures[0]));
}

TEST_CASE("a model that does not fit together is refused", "[model]")
{
    const auto refused = [](const auto& change, const std::string& reason)
    {
        Model model = two_materials();
        change(model);
        CHECK_THROWS_WITH(check_model(model, "the model"), Contains("the model: ") && Contains(reason));
    };
    check_model(two_materials(), "the model");
    refused([](Model& m) { m.material_of_face.pop_back(); }, "materials of 1 faces; expected 2");
    refused([](Model& m) { m.material_of_face[1] = 2; }, "face 1 names material 2 of 2");
    refused([](Model& m) { m.materials[0].picture = 1; }, "\"wall\" names picture 1 of 1");
    refused([](Model& m) { m.materials[0].color.y = 1.5F; }, "color outside of 0 to 1");
    refused([](Model& m) { m.mesh.texcoords.clear(); }, "has a picture, but the mesh has no texcoords");
    refused([](Model& m) { m.mesh.colors.clear(); }, "\"floor\" has vertex colors");
    refused([](Model& m) { m.mesh.triangles.clear(); }, "no faces");

    const testing::TemporaryFolder folder;
    Model model = two_materials();
    save(model, folder.path());
    model.pictures = {"../picture_0.png"};
    CHECK_THROWS_WITH(model.save({folder.path(), folder.path()}), Contains("is not a file name"));
    std::filesystem::remove(folder.path() / "picture_0.png");
    CHECK_THROWS_WITH(Model::load({folder.path(), folder.path()}), Contains("this picture of the model was not written"));
    std::string text = read_text_file(folder.path() / "model.json");
    text.replace(text.find("mirror"), 6, "murror");
    write_file(folder.path() / "model.json", text);
    CHECK_THROWS_WITH(Model::load({folder.path(), folder.path()}), Contains("model.json: materials[0].wrap[0]: "));
}

#include "catch.h"
#include "model_samples.h"
#include "world_mesh.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/recordings/layout.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

using Catch::Contains;
using fresco::Value;
using fresco::testing::TestRun;

namespace
{

struct MeshFile
{
    fresco::testing::TemporaryFolder folder;
    MeshFile()
    {
        fresco::Mesh mesh;
        mesh.positions = {{0, 0, 0}, {1000, 2000, 3000}, {0, 2000, 0}};
        mesh.triangles = {{0, 1, 2}};
        mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
        fresco::write_file(path(), fresco::to_ply(mesh));
    }
    std::filesystem::path path() const { return folder.path() / "mesh.ply"; }
};

fresco::Mesh read(const MeshFile& file, TestRun& run, Value options)
{
    options.set("path", file.path().string());
    const auto out = file.folder.path() / "out";
    fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "scan.mesh", options, {}, out, run);
    return *fresco::Mesh::load({out / "mesh", out});
}

}  // namespace

TEST_CASE("a mesh is brought into the world: unit, axes, transform", "[scan.mesh]")
{
    const MeshFile file;
    TestRun run;
    const auto moved = read(file, run,
                            Value::Map{{"unit_m", 0.001},
                                       {"axes", "x -z y"},
                                       {"transform", Value::List{0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30, 0, 0, 0, 1}}});
    // (1, 2, 3) m with y up is (1, -3, 2) with z up; a quarter turn makes it (3, 1, 2).
    CHECK(moved.positions[1] == fresco::Vec3f{13, 21, 32});
    CHECK(moved.positions[2] == fresco::Vec3f{10, 20, 32});
    CHECK(moved.colors[1] == fresco::Rgb8{4, 5, 6});
    CHECK(run.reported.at("extent_m").as_list().at(0).as_double() == Approx(3));
    CHECK(run.messages == std::vector<std::string>{"1 faces, 3.0 x 1.0 x 2.0 m"});
    CHECK(read(file, run, Value::Map{}).positions[1] == fresco::Vec3f{1000, 2000, 3000});
    CHECK_THAT(run.messages.at(1),
               Contains("warning: the mesh is 1000 x 2000 x 3000 m; set unit_m, the meters per unit of the file: ") &&
                   Contains("0.01 if it is in centimeters (30 m long), 0.001 if it is in millimeters (3 m long)"));
    read(file, run, Value::Map{{"unit_m", 1e-5}});
    CHECK_THAT(run.messages.at(3), Contains("warning: the mesh is 0.01 x 0.02 x 0.03 m; set unit_m"));
    // A small room in centimeters, and what is as long but flat, or low.
    using fresco::recordings::doubts_about_size;
    CHECK_THAT(doubts_about_size({180, 240, 200}), Contains("0.01 if it is in centimeters (2.4 m long)"));
    CHECK_THAT(doubts_about_size({180, 0, 200}), Contains("the mesh is 180 x 0 x 200 m; set unit_m"));
    CHECK(doubts_about_size({90, 280, 25}).empty());
    CHECK(doubts_about_size({0.2, 0.1, 0.35}).empty());
}

TEST_CASE("a file is read in double: far from 0, its mesh is stored less an offset, the frames' where they are wired",
          "[scan.mesh]")
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "floor.obj";
    fresco::write_file(file, "v 448001.234 5411002.5 112\nv 448005 5411002.501 112\nv 448001.25 5411006.75 112.5\nf 1 2 3\n");
    const auto read_far = [&](TestRun& run, const Value::Map& more, const fresco::testing::Inputs& inputs = {})
    {
        Value options = Value::Map{{"path", file.string()}};
        for (const auto& [name, value] : more)
            options.set(name, value);
        fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "scan.mesh", options, inputs, folder.path(), run);
        CHECK(fresco::Model::load({folder.path() / "model", folder.path()})->mesh.offset_m ==
              fresco::Mesh::load({folder.path() / "mesh", folder.path()})->offset_m);
        return *fresco::Mesh::load({folder.path() / "mesh", folder.path()});
    };
    const std::vector<fresco::Vec3f> expected{{1.234F, 2.5F, 112}, {5, 2.501F, 112}, {1.25F, 6.75F, 112.5F}};
    const fresco::Vec3d offset{448'000, 5'411'000, 0};
    TestRun run;
    const auto mesh = read_far(run, {});
    CHECK(mesh.positions == expected);
    CHECK(mesh.offset_m == offset);
    REQUIRE(run.messages.size() == 2);
    CHECK_THAT(run.messages[0], Contains("(448000, 5411000, 0) m are taken off all coordinates"));
    CHECK(run.reported.at("offset_m").as_list().at(1).as_double() == 5'411'000);
    TestRun moving;
    const auto moved =
        read_far(moving, {{"transform", Value::List{1, 0, 0, -448'000, 0, 1, 0, -5'411'000, 0, 0, 1, 0, 0, 0, 0, 1}}});
    CHECK(moved.positions == expected);
    CHECK(moved.offset_m == fresco::Vec3d{});
    CHECK(moving.reported.find("offset_m") == nullptr);
    CHECK(read_far(run,
                   {{"unit_m", 1000}, {"transform", Value::List{1, 0, 0, -448e6, 0, 1, 0, -5411e6, 0, 0, 1, -112e3, 0, 0, 0, 1}}})
              .positions[0] == fresco::Vec3f{1234, 2500, 0});

    const auto frames = std::make_shared<fresco::Frames>();
    frames->offset_m = {448'100, 5'411'000, 0};
    const auto beside = read_far(run, {}, {{"frames", frames}});
    CHECK(beside.offset_m == frames->offset_m);
    CHECK(beside.positions[1] == fresco::Vec3f{-95, 2.501F, 112});
    fresco::write_file(file, "v 448001.25 5411002.5 112\nv 448005 5411002.5 112\nv 448001.25 5411006.5 112.5\nf 1 2 3\n");
    TestRun coarse;
    read_far(coarse, {});
    CHECK_THAT(coarse.messages.at(1), Contains("warning: floor.obj: all its coordinates are floats"));
    frames->offset_m = {};
    CHECK_THROWS_WITH(read_far(run, {}, {{"frames", frames}}),
                      Contains("floor.obj: the mesh is 5430 km from the cameras, around (448000, 5411000, 0) and (0, 0, 0) m"));
}

TEST_CASE("axes turn and never mirror", "[scan.mesh]")
{
    CHECK(scan_mesh::axes_rotation("x y z") == fresco::Mat3{});
    CHECK(scan_mesh::axes_rotation("+x+y+z") == fresco::Mat3{});
    const auto turned = scan_mesh::axes_rotation("-y x z");
    CHECK(turned * fresco::Vec3d{1, 2, 3} == fresco::Vec3d{-2, 1, 3});
    CHECK(fresco::determinant(turned) == 1);
    for (const char* text : {"", "x y", "x y z x", "a b c", "xyz1"})
        CHECK_THROWS_WITH(scan_mesh::axes_rotation(text), Contains("is not valid; expected three axes"));
    CHECK_THROWS_WITH(scan_mesh::axes_rotation("x x z"), Contains("names an axis twice"));
    CHECK_THROWS_WITH(scan_mesh::axes_rotation("x z y"), Contains("mirrors"));
}

TEST_CASE("what cannot be moved is refused", "[scan.mesh]")
{
    const MeshFile file;
    TestRun run;
    const auto refused = [&](const char* option, const Value& value, const char* reason) {
        CHECK_THROWS_WITH(read(file, run, Value::Map{{option, value}}), Contains(reason));
    };
    refused("transform", Value::List{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1},
            "option \"transform\": the upper left 3x3 part is not a rotation");
    refused("transform", Value::List{1}, "option \"transform\": 1 numbers");
    refused("transform", Value::List{1, 0, 0, 1e300, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "out of range");
    refused("unit_m", 1e5, "mesh.ply in meters: vertex 1 is more than 1e7 m");
    fresco::Mesh small;
    small.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    small.triangles = {{0, 1, 2}};
    fresco::write_file(file.path(), fresco::to_ply(small));
    refused("unit_m", 1e-6, "in meters: the faces have an area of 5e-13 m²");
    fresco::write_file(file.path(), fresco::read_text_file(file.path()).substr(0, 200));
    CHECK_THROWS_WITH(read(file, run, Value::Map{}), Contains("mesh.ply"));
}

TEST_CASE("a picture in a model is named by the model", "[scan.mesh]")
{
    struct Refusing final : stored_png::Codec
    {
        fresco::ImageHeader check(const std::filesystem::path& file) const override
        {
            throw fresco::Error(file.string() + ": byte 33: damaged");
        }
    };
    const fresco::testing::TemporaryFolder folder;
    const auto glb = model_samples::write_glb_box(folder.path());
    const auto obj = model_samples::write_obj_box(folder.path());
    for (const auto& [file, name] : {std::pair(glb, glb.string() + ": image 0"), {obj, (folder.path() / "side 0.png").string()}})
    {
        TestRun run;
        const auto read = [&, file = file]
        {
            fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "scan.mesh", Value::Map{{"path", file.string()}}, {},
                                       folder.path() / "out", run, {{"image_io", std::make_shared<Refusing>()}});
        };
        CHECK(fresco::testing::error_of(read) == name + ": byte 33: damaged");
    }
}

TEST_CASE("a model goes on with its materials and pictures", "[scan.mesh]")
{
    const fresco::testing::TemporaryFolder folder;
    const auto run_on = [&](const std::filesystem::path& path, TestRun& run, Value options = Value::Map{})
    {
        options.set("path", path.string());
        std::filesystem::remove_all(folder.path() / "out");
        fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "scan.mesh", options, {}, folder.path() / "out", run,
                                   {{"image_io", std::make_shared<stored_png::Codec>()}});
        return fresco::Model::load({folder.path() / "out/model", folder.path()});
    };
    const std::filesystem::path glb = model_samples::write_glb_box(folder.path());
    const std::filesystem::path obj = model_samples::write_obj_box(folder.path());
    for (const auto& file : {glb, obj})
    {
        TestRun run;
        const auto model = run_on(file, run, Value::Map{{"unit_m", 0.5}});
        CHECK(run.reported.at("pictures").as_int() == 6);
        CHECK(run.reported.at("materials").as_int() == 6);
        CHECK(run.messages == std::vector<std::string>{"12 faces, 2.0 x 1.5 x 1.0 m, 6 pictures"});
        CHECK(run.files_read.size() == (file == glb ? 0 : 7));
        for (std::size_t side = 0; side < 6; ++side)
        {
            CHECK(stored_png::Codec().read_rgb(model->loaded_from / model->pictures.at(side)) ==
                  model_samples::Box::picture(side));
            CHECK(model->materials.at(model->material_of_face.at(2 * side + 1)).picture == static_cast<int>(side));
            CHECK((file == obj || model->mesh.texcoords[6 * side] == fresco::Vec2f{0, 0}));
            CHECK((file == obj || model->mesh.texcoords[6 * side + 2] == fresco::Vec2f{1, 1}));
        }
        const auto mesh = fresco::Mesh::load({folder.path() / "out/mesh", folder.path()});
        CHECK(mesh->positions == model->mesh.positions);
        CHECK(mesh->positions.size() == (file == glb ? 8 : 24));
        CHECK(model->mesh.triangles.size() == 12);
    }
    TestRun run;
    CHECK(run_on(obj, run, Value::Map{{"materials", "skip"}})->pictures.empty());
    CHECK(run.files_read.empty());
    const auto picture = folder.path() / "side 3.png";
    std::string compressed = fresco::read_text_file(picture);
    compressed[43] = 5;  // the first block's kind, which the codec of tests refuses
    fresco::write_file(picture, compressed);
    CHECK_THROWS_WITH(run_on(obj, run), Contains("side 3.png: "));
}

#include "catch.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>

#include <filesystem>

using namespace fresco;
using Catch::Contains;

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
    CHECK(loaded->mesh.texcoords == model.mesh.texcoords);
    CHECK(loaded->mesh.colors == model.mesh.colors);
    CHECK(loaded->material_of_face == model.material_of_face);
    REQUIRE(loaded->materials.size() == 2);
    CHECK(loaded->materials[0].name == "wall");
    CHECK(loaded->materials[0].color == model.materials[0].color);
    CHECK(loaded->materials[0].picture == 0);
    CHECK(loaded->materials[0].wrap_u == Wrap::mirror);
    CHECK(loaded->materials[0].wrap_v == Wrap::clamp);
    CHECK(loaded->materials[1].vertex_colors);
    CHECK(loaded->pictures == model.pictures);
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

#include "catch.h"
#include "model_samples.h"

#include <fresco/files.h>
#include <fresco/testing.h>
#include <fresco/texture.h>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

struct Exported : testing::TemporaryFolder
{
    testing::TestRun run;
    std::string model_name = "wall.ply";
    std::shared_ptr<Model> model = std::make_shared<Model>();
    std::shared_ptr<TexturedMesh> painted = std::make_shared<TexturedMesh>();

    Exported()
    {
        model->mesh = testing::two_chart_wall();
        model->materials.resize(1);
        model->material_of_face.assign(model->mesh.triangles.size(), 0);
        model->loaded_from = path();
        painted->mesh = model->mesh;
        painted->image = Image(testing::noise_picture(32, 32, 1));
        write_file(path() / "wall.ply", to_ply(model->mesh));
    }

    Files files(const char* uvs)
    {
        const Value options =
            Value::Map{{"file", (path() / model_name).string()}, {"uvs", uvs}, {"path", "deep/wall"}, {"image_format", "png"}};
        testing::run_stage(FRESCO_PLUGIN_FILE, "export.model", options, {{"textured_mesh", painted}, {"model", model}},
                           path() / "out", run, {{"image_io", std::make_shared<stored_png::Codec>()}});
        return *Files::load({path() / "out/files", {}});
    }

    std::string contents(const std::string& name) const { return read_text_file(path() / "out/files" / name); }
};

}  // namespace

TEST_CASE("The model's own texcoords are kept where the atlas has them")
{
    Exported exported;
    CHECK(exported.files("auto").names == std::vector<std::string>{"deep/wall.ply", "deep/wall.png"});
    CHECK(exported.run.reported.at("uvs") == Value("keep"));
    const std::string mesh = exported.contents("deep/wall.ply");
    const std::string own = read_text_file(exported.path() / "wall.ply");
    CHECK(mesh.substr(mesh.find("end_header")) == own.substr(own.find("end_header")));
    CHECK(stored_png::Codec().read_rgb(exported.path() / "out/files/deep/wall.png") == exported.painted->image.pixels);

    for (Vec2f& uv : exported.painted->mesh.texcoords)
        uv = uv * 0.5F;
    CHECK_THROWS_WITH(exported.files("keep"), Catch::Contains("uvs: keep"));
    exported.files("auto");
    CHECK(exported.run.reported.at("uvs") == Value("second"));
    CHECK(read_mesh(exported.path() / "out/files/deep/wall.ply").texcoords == exported.painted->mesh.texcoords);
}

TEST_CASE("uvs: new writes a GLB of the atlas, whatever the model's file is")
{
    Exported exported;
    exported.painted->mesh = testing::wall();
    testing::set_texcoords(exported.painted->mesh, [](Vec3f p) { return Vec2f{(p.x + 2) / 4, (p.y + 2) / 4}; });
    CHECK(exported.files("new").names == std::vector<std::string>{"deep/wall.glb"});
    CHECK(exported.contents("deep/wall.glb").starts_with("glTF"));
}

TEST_CASE("A model of a format that is only read becomes a GLB")
{
    Exported exported;
    fs::rename(exported.path() / "wall.ply", exported.path() / "wall.fbx");
    exported.model_name = "wall.fbx";
    CHECK(exported.files("auto").names == std::vector<std::string>{"deep/wall.glb"});
    CHECK_THAT(exported.run.messages.at(0), Catch::Contains("wall.fbx"));
}

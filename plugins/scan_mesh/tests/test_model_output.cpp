#include "catch.h"
#include "model_samples.h"

#include <fresco/files_io.h>
#include <fresco/model.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

using Catch::Contains;
using fresco::Value;
using fresco::testing::TestRun;

TEST_CASE("a model goes on with its materials and pictures", "[scan.mesh]")
{
    const fresco::testing::TemporaryFolder folder;
    const auto run_on = [&](const std::filesystem::path& path, TestRun& run, Value options = Value::Map{})
    {
        options.set("path", path.string());
        std::filesystem::remove_all(folder.path() / "out");
        fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "scan.mesh", options, {}, folder.path() / "out", run,
                                   {{"images", std::make_shared<stored_png::Codec>()}});
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
            CHECK(stored_png::Codec().read_rgb(model->loaded_from / model->pictures.at(side)) ==
                  model_samples::Box::picture(side));
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

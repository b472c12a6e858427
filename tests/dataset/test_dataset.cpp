#include "catch.h"
#include "npy_codec.h"
#include "small_recording.h"

#include <fresco/files.h>
#include <fresco/testing.h>

#include <cmath>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

void run_plugin(const std::string& type, const Value& options, const testing::Inputs& inputs, const fs::path& out)
{
    std::string library = type + ".so";
    library[library.find('.')] = '_';
    testing::TestRun run;
    testing::run_stage(fs::path(FRESCO_PLUGINS) / library, type, options, inputs, out, run,
                       {{"images", std::make_shared<NpyCodec>()}});
}

}  // namespace

TEST_CASE("what dataset.read gives is what dataset.write was given")
{
    const testing::TemporaryFolder folder;
    const SmallRecording sent(folder.path());
    const auto style = std::make_shared<Image>(Raster8(80, 70, 3, 99));
    const fs::path out = folder.path() / "out";
    for (const std::string uv : {"float32", "uint16"})
    {
        run_plugin("dataset.write", Value::Map{{"uv", uv}, {"images", Value::Map{{"type", "image.none"}}}},
                   {{"uvmaps", sent.maps}, {"frames", sent.frames}, {"mesh", sent.mesh}, {"style", style}}, out);
        run_plugin("dataset.read", Value::Map{{"path", (out / "files/dataset").string()}}, {}, out);

        const auto maps = UvMaps::load({out / "uvmaps", out});
        const auto frames = Frames::load({out / "frames", out});
        CHECK(maps->heights_px == sent.maps->heights_px);
        REQUIRE(maps->views.size() == sent.maps->views.size());
        REQUIRE(frames->frames.size() == sent.frames->frames.size());
        for (std::size_t i = 0; i < maps->views.size(); ++i)
        {
            CHECK(maps->views[i].sequence == sent.maps->views[i].sequence);
            CHECK(maps->views[i].frame == sent.maps->views[i].frame);
            CHECK(maps->views[i].camera == sent.maps->views[i].camera);
            CHECK(maps->views[i].valid_pixels == sent.maps->views[i].valid_pixels);
            for (std::size_t level = 0; level < maps->heights_px.size(); ++level)
            {
                const UvMap got = maps->load_map(i, level);
                const UvMap map = sent.maps->load_map(i, level);
                CHECK(got.depth == map.depth);
                CHECK(got.cosine == map.cosine);
                CHECK(got.valid == map.valid);
                if (uv == "float32")
                    CHECK(got.uv == map.uv);
                else
                    for (std::size_t k = 0; k < map.uv.values.size(); ++k)
                        CHECK(std::abs(got.uv.values[k] - map.uv.values[k]) <= 0.5001 / 65535);
            }
            const Frame& frame = frames->frames[i];
            CHECK(frame.name == sent.frames->frames[i].name);
            CHECK(frame.number == sent.frames->frames[i].number);
            CHECK(frame.color == sent.frames->frames[i].color);
            CHECK(frame.depth == sent.frames->frames[i].depth);
            CHECK(load_color(frame, nullptr) == load_color(sent.frames->frames[i], nullptr));
            REQUIRE(frame.depth_picture.empty() == sent.frames->frames[i].depth_picture.empty());
            if (!frame.depth_picture.empty())
                CHECK(load_depth(frame, nullptr) == load_depth(sent.frames->frames[i], nullptr));
        }
        CHECK(Image::load({out / "style", out})->pixels == style->pixels);
        const auto mesh = Mesh::load({out / "mesh", out});
        CHECK(mesh->positions == sent.mesh->positions);
        CHECK(mesh->triangles == sent.mesh->triangles);
        CHECK(mesh->texcoords == sent.mesh->texcoords);
        CHECK(mesh->charts == sent.mesh->charts);
    }
}

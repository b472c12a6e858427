#include "catch.h"
#include "small_recording.h"
#include "view_writer.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/files_io.h>
#include <fresco/images/sharpness.h>
#include <fresco/mesh.h>

#include <cmath>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

dataset::Manifest manifest_at(const fs::path& folder)
{
    return dataset::parse_manifest(read_text_file(folder / "dataset.json"), "dataset.json");
}

}  // namespace

TEST_CASE_METHOD(Recorded, "the folder holds every view's maps and pictures, and the manifest lists and stamps each file")
{
    recording.inputs["style"] = std::make_shared<Image>(Raster8(9, 7, 4, 200));
    const auto agreement = std::make_shared<Table>();
    agreement->columns = {"error_before", "error_after", "median_moved_px", "most_moved_px"};
    agreement->rows = {{0.25, 0.125, 7.0, 11.5}};
    recording.inputs["agreement"] = agreement;
    const auto names = recording.write();
    const fs::path made = recording.out / "files/dataset";
    const auto manifest = manifest_at(made);

    CHECK(manifest.uv == dataset::UvType::float32);
    CHECK(manifest.heights_px == std::vector<int>{12, 45});
    CHECK(manifest.agreement == dataset::Agreement{0.25, 0.125, 7, 11.5});
    REQUIRE(manifest.views.size() == 3);
    // 3 views x (2 heights x 5 quantities + picture) + 2 depth pictures + style, mesh and loader; the manifest is last and lists
    // all others.
    CHECK(manifest.files.size() == 3 * 11 + 2 + 3);
    CHECK_THAT(manifest.writer, Catch::StartsWith("fresco "));
    CHECK_THAT(read_text_file(made / "fresco_dataset.py"), Contains("class Dataset:"));
    REQUIRE(names.size() == manifest.files.size() + 1);
    CHECK(names.back() == "dataset/dataset.json");
    for (const auto& [name, stamp] : manifest.files)
    {
        CHECK(fs::file_size(made / name) == stamp.bytes);
        CHECK(file_hash(made / name) == stamp.hash);
    }
    const auto holds = [&]<class T>(const char* name, const Raster<T>& meant)
    {
        INFO(name);
        CHECK(dataset::raster_from<T>(read_file(made / name), meant.width, meant.height, meant.channels, name) == meant);
    };
    const UvMap map = recording.maps->load_map(1, 1);
    const Raster8 picture = load_color(recording.frames->frames[1], nullptr);
    holds("views/000001/uv_45.npy", map.uv);
    holds("views/000001/depth_45.npy", map.depth);
    holds("views/000001/cosine_45.npy", map.cosine);
    holds("views/000001/valid_45.npy", map.valid);
    holds("views/000001/color_45.npy", resized(picture, 60, 45));
    holds("views/000001/color_12.npy", resized(picture, 16, 12));
    holds("views/000001/color.npy", picture);
    holds("views/000001/sensor_depth.npy", load_depth_steps(recording.frames->frames[1], nullptr));
    holds("style.npy", Raster8(9, 7, 4, 200));
    CHECK_FALSE(fs::exists(made / "views/000002/sensor_depth.npy"));
    CHECK(read_file(made / "mesh.ply") == to_ply(*recording.mesh));

    const dataset::View& view = manifest.views[1];
    CHECK((view.frame == "frame-10" && view.number == 10 && view.depth_unit_m == 0.002));
    CHECK(view.color == recording.frames->frames[1].color);
    CHECK(view.depth == recording.frames->frames[1].depth);
    CHECK_FALSE(manifest.views[2].depth_unit_m);
    CHECK(view.sharpness == sharpness(picture, 320, 240));
    CHECK(view.valid_pixels == recording.maps->views[1].valid_pixels);
}

TEST_CASE_METHOD(Recorded, "texcoords as uint16 are round(65535 u); the path is the folder's name")
{
    const auto names = recording.write(Value::Map{{"uv", "uint16"}, {"path", "a/b"}});
    const fs::path made = recording.out / "files/a/b";
    CHECK(names.back() == "a/b/dataset.json");
    CHECK(manifest_at(made).uv == dataset::UvType::uint16);
    CHECK_FALSE(manifest_at(made).has_style);
    const RasterF uv = recording.maps->load_map(0, 0).uv;
    const Raster16 stored = dataset::raster_from<std::uint16_t>(read_file(made / "views/000000/uv_12.npy"), 16, 12, 2, "uv");
    for (std::size_t i = 0; i < uv.values.size(); ++i)
        CHECK(stored.values[i] == std::lround(65535.0 * static_cast<double>(uv.values[i])));
}

TEST_CASE_METHOD(Recorded, "frames without a uv map are left out, uv maps without their frame are refused")
{
    recording.frames->frames.push_back(recording.frames->frames[0]);
    recording.frames->frames.back().name = "other";
    recording.write();
    CHECK(manifest_at(recording.out / "files/dataset").views.size() == 3);
    CHECK(recording.run.messages == std::vector<std::string>{"1 of 4 frames have no uv map and are left out"});

    Frames frames = *recording.frames;
    frames.frames[1].name = "frame-11";
    CHECK_THROWS_WITH(checked_frames(*recording.maps, frames), Contains("seq-01/frame-10, which is missing on port 'frames'"));
    frames = *recording.frames;
    frames.frames[1].color.world_from_camera.translation.x += 1e-9;
    CHECK_THROWS_WITH(checked_frames(*recording.maps, frames), Contains("uv map of seq-01/frame-10 does not match"));
    frames = *recording.frames;
    frames.frames.back().name = "frame-0";
    CHECK_THROWS_WITH(checked_frames(*recording.maps, frames), Contains("seq-01/frame-0 appears twice"));
    CHECK(checked_frames(*recording.maps, *recording.frames) == std::vector<std::size_t>{0, 1, 2});
}

TEST_CASE_METHOD(Recorded, "what the reader would refuse is not written")
{
    const testing::Inputs right = recording.inputs;
    const auto refused = [&](testing::Inputs other, const char* why)
    {
        other.insert(right.begin(), right.end());
        recording.inputs = other;
        CHECK_THROWS_WITH(recording.write(Value::Map{{"uv", "uint16"}}), Contains(why));
    };
    refused({{"style", std::make_shared<Image>()}}, "the picture on port 'style': a picture of 0 x 0");
    const auto bare = std::make_shared<Mesh>(*recording.mesh);
    bare->texcoords.clear();
    refused({{"mesh", bare}}, "has no texcoords");
    const auto fine = std::make_shared<UvMaps>(*recording.maps);
    fine->texture_px = 8192;
    refused({{"uvmaps", fine}}, "set uv: float32");
    refused({{"agreement", std::make_shared<Table>()}}, "on port 'agreement' has other columns");
    refused({{"uvmaps", std::make_shared<UvMaps>()}}, "has no uv maps");
    const auto renamed = std::make_shared<Frames>(*recording.frames);
    const auto maps = std::make_shared<UvMaps>(*recording.maps);
    renamed->frames[0].sequence = maps->views[0].sequence = "a/b";
    refused({{"frames", renamed}, {"uvmaps", maps}}, "views[0].sequence: \"a/b\" cannot be part");
    SmallRecording hole;
    UvMap map = hole.maps->load_map(2, 0);
    map.depth.at(5, 3) = 0;
    map.valid.at(5, 3) = 1;
    UvMaps::write_map({hole.folder.path() / "maps", {}}, 2, 12, map);
    CHECK_THROWS_WITH(hole.write(), Contains("seq-01/frame-20 at 12 px, depth: pixel (5, 3) is valid"));
}

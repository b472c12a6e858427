#include "catch.h"
#include "shared_data.h"
#include "stored_png.h"

#include <fresco/component.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

/// Runs stages, each into a folder of its own.
struct Pipeline
{
    testing::TemporaryFolder folder;

    template <class T>
    std::shared_ptr<T> run(const char* library, const std::string& type, const std::string& port, const Value& options,
                           const testing::Inputs& inputs) const
    {
        const std::shared_ptr<Component> layout = testing::make_from_plugin<Component>(LAYOUT_FRAMES_PLUGIN, "layout.frames");
        testing::TestFactory none;
        layout->configure(Value::Map{}, none);
        testing::TestRun run;
        testing::run_stage(library, type, options, inputs, folder.path() / type, run,
                           {{"image_io", std::make_shared<stored_png::Codec>()}, {"layout", layout}});
        return T::load({folder.path() / type / port, folder.path()});
    }

    std::shared_ptr<Mesh> atlas(const std::shared_ptr<Mesh>& mesh, int max_faces) const
    {
        const auto fewer = run<Mesh>(MESH_DECIMATE_PLUGIN, "mesh.decimate", "simplified", Value::Map{{"max_faces", max_faces}},
                                     {{"mesh", mesh}});
        return run<Mesh>(ATLAS_PROJECT_PLUGIN, "atlas.project", "atlas", Value::Map{{"size_px", 256}}, {{"mesh", fewer}});
    }

    /// Paints an atlas in one color and writes it.
    fs::path exported(const char* library, const std::string& type, const std::shared_ptr<Mesh>& atlas,
                      const Value& options) const
    {
        Texture gray = testing::blank_texture(256, 0.5F);
        testing::see(gray, {0, 0}, {1, 1}, {0.5F, 0.5F, 0.5F});
        const auto painted = run<TexturedMesh>(TEXTURE_BAKE_PLUGIN, "texture.bake", "textured_mesh", Value::Map{},
                                               {{"texture", std::make_shared<Texture>(gray)}, {"mesh", atlas}});
        const auto files = run<Files>(library, type, "files", options, {{"textured_mesh", painted}});
        return files->loaded_from / files->names.at(0);
    }
};

std::vector<Vec3d> positions_in(const fs::path& file)
{
    MeshReadReport report;
    read_mesh(file, {}, &report);
    return report.positions;
}

}  // namespace

TEST_CASE("a floor in a map's coordinates comes out where it was", "[far]")
{
    const Pipeline pipeline;
    // 4 m x 4 m in squares of 10 cm, at millimeters.
    std::string text;
    const auto meters = [](int thousandths) { return fmt::format(" {}.{:03}", thousandths / 1000, thousandths % 1000); };
    for (int v = 0; v < 41 * 41; ++v)
        text += "v" + meters(448'000'017 + v / 41 * 100) + " 541" + meters(1'003'208 + v % 41 * 100).substr(1) + " 112.003\n";
    for (int v = 1; v < 40 * 41; ++v)
        if (v % 41 != 0)
            text += fmt::format("f {} {} {} {}\n", v, v + 41, v + 42, v + 1);
    std::vector<fs::path> scans{pipeline.folder.path() / "floor.obj"};
    write_file(scans[0], text);
    if (const auto shared = shared_data("failing/models", "the floors in UTM coordinates"); !shared.empty())
        scans.insert(scans.end(), {shared / "utm_floor.obj", shared / "utm_floor_double.ply"});
    for (const auto& scan : scans)
    {
        INFO(scan.string());
        const auto mesh = pipeline.run<Mesh>(SCAN_MESH_PLUGIN, "scan.mesh", "mesh", Value::Map{{"path", scan.string()}}, {});
        CHECK(mesh->triangles.size() == 3200);
        CHECK(mesh->offset_m == Vec3d{448'000, 5'411'000, 0});
        const auto atlas = pipeline.atlas(mesh, 4000);
        auto expected = positions_in(scan);
        for (const char* name : {"room.ply", "room.obj"})
        {
            const auto file = pipeline.exported(EXPORT_MESH_PLUGIN, "export.mesh", atlas,
                                                Value::Map{{"path", name}, {"coordinates", "original"}});
            auto found = positions_in(file);
            const auto order = [](const Vec3d& p) { return std::tuple(std::round(p.x * 1000), std::round(p.y * 1000)); };
            std::ranges::sort(found, {}, order);
            const auto rest = std::ranges::unique(found, {}, order);  // Seams of the atlas split vertices.
            found.erase(rest.begin(), rest.end());
            std::ranges::sort(expected, {}, order);
            CHECK(found == expected);
        }
    }
}

TEST_CASE("a recording in a map's coordinates gives the bytes that it gives near 0", "[far]")
{
    const Vec3d utm{448'000, 5'411'000, 0};
    const Mesh room = testing::room({3, 2.5F, 2});
    struct Made
    {
        std::string fused;
        std::string glb;
        std::vector<Vec3d> exported;
    };
    const auto make = [&](Vec3d moved)
    {
        const Pipeline p;
        Made made;
        const fs::path recording = p.folder.path() / "recording";
        fs::create_directories(recording);
        Frames frames;
        for (int i = 0; i < 8; ++i)
        {
            Camera camera = testing::camera(96, 72, 60, {1.5, 1.25, 1}, i * std::numbers::pi / 4);
            Frame& frame = frames.frames.emplace_back(testing::frame(fmt::format("frame-{}", i), camera, i));
            testing::set_depth_picture(frame, recording, testing::depth_of(room, camera));
            testing::set_color_picture(frame, recording, testing::noise_picture(96, 72, 5));
            for (Camera* const each : {&frame.color, &frame.depth})
                each->world_from_camera.translation += moved;
        }
        frames.save({recording, {}});
        const auto read =
            p.run<Frames>(SCAN_RECORDING_PLUGIN, "scan.recording", "frames", Value::Map{{"path", recording.string()}}, {});
        CHECK(read->offset_m == moved);
        const auto sharp = p.run<Frames>(FRAMES_SHARPEST_PLUGIN, "frames.sharpest", "frames",
                                         Value::Map{{"measure", "laplacian_variance"}, {"min_sharpness", 0}}, {{"frames", read}});
        const auto fused = p.run<Mesh>(MESH_FUSE_PLUGIN, "mesh.fuse", "mesh", Value::Map{{"voxel_m", 0.05}}, {{"frames", sharp}});
        made.fused = read_text_file(p.folder.path() / "mesh.fuse/mesh/mesh.ply");
        const auto atlas = p.atlas(fused, 500);
        const auto chosen =
            p.run<Frames>(FRAMES_COVER_PLUGIN, "frames.cover", "frames", Value::Map{}, {{"frames", sharp}, {"mesh", atlas}});
        CHECK(chosen->offset_m == moved);
        made.glb = read_text_file(p.exported(EXPORT_GLTF_PLUGIN, "export.gltf", atlas, Value::Map{}));
        made.exported = positions_in(p.exported(EXPORT_MESH_PLUGIN, "export.mesh", atlas,
                                                Value::Map{{"path", "room.ply"}, {"coordinates", "original"}, {"up", "keep"}}));
        return made;
    };
    const Made near = make({});
    Made far = make(utm);
    const std::string comment = "comment offset_m 448000 5411000 0\n";
    REQUIRE(far.fused.find(comment) != std::string::npos);
    CHECK(far.fused.erase(far.fused.find(comment), comment.size()) == near.fused);
    CHECK(far.glb.find("\"offset_m\":[448000.0,5411000.0,0.0]") != std::string::npos);
    const auto binary = [](const std::string& file) { return file.substr(file.find("BIN")); };
    CHECK(binary(far.glb) == binary(near.glb));
    REQUIRE(far.exported.size() == near.exported.size());
    for (std::size_t v = 0; v < near.exported.size(); ++v)
        CHECK(length(far.exported[v] - near.exported[v] - utm) < 1e-5);
}

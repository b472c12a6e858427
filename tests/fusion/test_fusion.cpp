#include "catch.h"
#include "recording_layouts.h"
#include "shared_data.h"
#include "surface_samples.h"

#include <fresco/component.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

namespace fs = std::filesystem;
using fresco::Frames;
using fresco::Mesh;
using fresco::Value;

namespace
{

/// Runs a stage; gives the folder of its outputs.
fs::path run(const char* library, const char* type, const Value& options, const fresco::testing::Inputs& inputs,
             const fs::path& out)
{
    fresco::testing::TestRun run;
    fresco::testing::run_stage(
        library, type, options, inputs, out, run,
        {{"image_io", fresco::testing::make_from_plugin<fresco::ImageIo>(IMAGE_OPENCV_PLUGIN, "image.opencv")}});
    return out;
}

/// Reads a recording by a layout; gives the folder of its outputs.
fs::path read(const char* layout_library, const char* layout, const Value& layout_options, const Value& options,
              const fs::path& out)
{
    fresco::testing::TestFactory none;
    const std::shared_ptr<fresco::Component> known = fresco::testing::make_from_plugin<fresco::Component>(layout_library, layout);
    known->configure(layout_options, none);
    fresco::testing::TestRun run;
    fresco::testing::run_stage(
        SCAN_RECORDING_PLUGIN, "scan.recording", options, {}, out, run,
        {{"image_io", fresco::testing::make_from_plugin<fresco::ImageIo>(IMAGE_OPENCV_PLUGIN, "image.opencv")},
         {"layout", known}});
    return out;
}

Mesh mesh_in(const fs::path& out)
{
    return *Mesh::load({out / "mesh", out});
}

/// Mean distance of the points on `mesh` that lie within a range of `reference`.
struct Distance
{
    double mean_m = 0;
    double covered = 0;  ///< Their share of all points.
};

Distance distance(const Mesh& mesh, const Mesh& reference, double range_m)
{
    auto distances = sampled_distances(mesh, reference);
    const auto all = static_cast<double>(distances.size());
    distances.erase(std::ranges::lower_bound(distances, range_m), distances.end());
    return {mean(distances), static_cast<double>(distances.size()) / all};
}

}  // namespace

TEST_CASE("the generated room's surface comes back from its depth pictures, read through a layout without a mesh", "[fusion]")
{
    const fresco::testing::TemporaryFolder folder;
    const auto path = [&](const char* name) { return folder.path() / name; };
    // The truth: what the pictures can show, without the errors of a scanner.
    const Value size =
        Value::Map{{"size_m", Value::List{3.5, 3, 2.6}}, {"frames_count", 26}, {"color_width_px", 320}, {"color_height_px", 240}};
    Value exact = size;
    exact.set("noise_m", 0);
    exact.set("edge_m", 0.015);
    const Mesh truth = mesh_in(run(SCAN_SYNTHETIC_ROOM_PLUGIN, "scan.synthetic_room", exact, {}, path("truth")));
    Value rough = size;
    rough.set("edge_m", 0.1);
    run(SCAN_SYNTHETIC_ROOM_PLUGIN, "scan.synthetic_room", rough, {}, path("room"));
    Frames frames = *Frames::load({path("room") / "frames", path("room")});
    // The layout has one camera.
    for (fresco::Frame& frame : frames.frames)
        frame.color = frame.depth;
    fresco::testing::write_tum(frames, path("tum"));
    const auto& k = frames.frames[0].depth.intrinsics;
    const auto scan =
        read(LAYOUT_TUM_PLUGIN, "layout.tum", Value::Map{{"intrinsics", Value::List{k.fx, k.fy, k.cx - 0.5, k.cy - 0.5}}},
             Value::Map{{"path", path("tum").string()}, {"depth_unit_m", 0.001}}, path("scan"));
    const Mesh fused = mesh_in(run(MESH_FUSE_PLUGIN, "mesh.fuse", Value::Map{{"voxel_m", 0.01}},
                                   {{"frames", Frames::load({scan / "frames", scan})}}, path("fused")));
    const Distance added = distance(fused, truth, 1);
    const Distance lost = distance(truth, fused, 0.05);
    INFO("to the truth " << added.mean_m << " m, from it " << lost.mean_m << " m over " << lost.covered);
    CHECK(added.mean_m < 0.005);
    CHECK(lost.mean_m < 0.005);
    CHECK(lost.covered > 0.9);
}

TEST_CASE("a part of the kitchen comes back", "[fusion]")
{
    const auto kitchen = shared_data("kitchen", "mesh.fuse on the kitchen");
    if (kitchen.empty())
        return;
    const fresco::testing::TemporaryFolder folder;
    const auto scan = read(LAYOUT_SEVEN_SCENES_PLUGIN, "layout.seven_scenes", Value::Map{},
                           Value::Map{{"path", kitchen.string()}, {"every", 4}}, folder.path() / "scan");
    const Mesh fused = mesh_in(run(MESH_FUSE_PLUGIN, "mesh.fuse", Value::Map{{"voxel_m", 0.01}},
                                   {{"frames", Frames::load({scan / "frames", scan})}}, folder.path() / "fused"));
    const Distance added = distance(fused, mesh_in(scan), 0.1);
    INFO("to the recording's mesh " << added.mean_m << " m over " << added.covered);
    CHECK(added.mean_m < 0.005);
    CHECK(added.covered > 0.97);
}

#include "catch.h"
#include "shared_data.h"
#include "surface_samples.h"

#include <fresco/component.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

namespace fs = std::filesystem;
using fresco::Frames;
using fresco::Mesh;
using fresco::Value;

TEST_CASE("a part of the kitchen comes back", "[fusion]")
{
    const auto kitchen = shared_data("kitchen", "mesh.fuse on the kitchen");
    if (kitchen.empty())
        return;
    const fresco::testing::TemporaryFolder folder;
    const fs::path scan = folder.path() / "scan", fused = folder.path() / "fused";
    const std::shared_ptr<fresco::Component> images =
        fresco::testing::make_from_plugin<fresco::Component>(IMAGE_OPENCV_PLUGIN, "image.opencv");
    const std::shared_ptr<fresco::Component> layout =
        fresco::testing::make_from_plugin<fresco::Component>(LAYOUT_SEVEN_SCENES_PLUGIN, "layout.seven_scenes");
    fresco::testing::TestFactory none;
    layout->configure(Value::Map{}, none);
    fresco::testing::TestRun run;
    fresco::testing::run_stage(SCAN_RECORDING_PLUGIN, "scan.recording", Value::Map{{"path", kitchen.string()}, {"every", 4}}, {},
                               scan, run, {{"image_io", images}, {"layout", layout}});
    fresco::testing::run_stage(MESH_FUSE_PLUGIN, "mesh.fuse", Value::Map{{"voxel_m", 0.01}},
                               {{"frames", Frames::load({scan / "frames", scan})}}, fused, run, {{"image_io", images}});
    // Only points within 10 cm of the recording's mesh count: the rest is what it lacks.
    auto distances = sampled_distances(*Mesh::load({fused / "mesh", fused}), *Mesh::load({scan / "mesh", scan}));
    const auto all = static_cast<double>(distances.size());
    distances.erase(std::ranges::lower_bound(distances, 0.1), distances.end());
    CHECK(mean(distances) < 0.005);
    CHECK(static_cast<double>(distances.size()) > 0.97 * all);
}

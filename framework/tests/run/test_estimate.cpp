#include <catch2/catch.hpp>

#include "hand_made_catalog.h"

#include "run/estimate.h"

using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{
/// Six pictures, of which every second is taken, and a mesh file of 2 000 bytes: 3 frames and 200 faces.
struct Scanned : TemporaryFolder
{
    Scanned()
    {
        for (const char* name : {"a", "b", "c", "d", "e", "f"})
            write("scan/" + std::string(name) + ".png", "x");
        write("scan/mesh.ply", std::string(2000, 'x'));
        write("pic.jpg", "x");
        write("room.ply", "x");
    }
};

const std::string stages = R"(version: 1
stages:
  scan:    {type: scan.folder, path: scan, every: 2}
  frames:  {type: frames.sharpest, input: scan}
  mesh:    {type: mesh.decimate,   input: scan, max_faces: 50}
  uvmaps:  {type: uvmaps.raycast,  input: {mesh: mesh, frames: frames}, heights_px: [100, 200]}
  texture: {type: texture.optimize, input: {maps: uvmaps, frames: frames, style: {file: pic.jpg}}}
)";

const StageEstimate& of(const PipelineEstimate& estimate, const std::string& stage)
{
    for (const StageEstimate& entry : estimate.stages)
        if (entry.stage == stage)
            return entry;
    throw std::runtime_error("no estimate for " + stage);
}
}  // namespace

TEST_CASE("Costs follow frames and faces along the wires", "[estimate]")
{
    const Scanned folder;
    const Catalog catalog = hand_made_catalog();
    const PipelineResult result = check(folder, stages, catalog);
    REQUIRE(lines(result).empty());
    const PipelineEstimate estimate = estimate_pipeline(result.pipeline, 2);
    // A stage without inputs counts by what it makes.
    CHECK(of(estimate, "scan").frames == 3.0);
    CHECK(of(estimate, "scan").faces == 200.0);
    CHECK(*of(estimate, "scan").seconds == Approx(1.03));
    CHECK(*of(estimate, "frames").seconds == Approx(0.02 * 3 / 2));
    CHECK(of(estimate, "mesh").faces == 50.0);
    // A mesh says nothing of frames, frames nothing of faces.
    CHECK_FALSE(of(estimate, "mesh").frames.has_value());
    CHECK_FALSE(of(estimate, "frames").faces.has_value());
    CHECK(*of(estimate, "mesh").seconds == Approx(200 / 1e6));
    CHECK(*of(estimate, "mesh").disk_mb == Approx(50 / 1e4));
    CHECK(*of(estimate, "uvmaps").seconds == Approx(3 * (100. * 100 + 200. * 200) * 1e-6));
    CHECK(*of(estimate, "uvmaps").memory_mb == 20);
    CHECK(of(estimate, "uvmaps").faces == 50.0);
    CHECK(of(estimate, "texture").seconds == 3.0);
    CHECK(estimate.seconds == Approx(1.03 + 0.03 + 0.0002 + 0.15 + 3));
    CHECK(estimate.memory_mb == Approx(100 + 200 / 1e4));
    CHECK(estimate.disk_mb == Approx(1 + 0 + 0.005 + 3 + 1));
    CHECK(estimate.complete);
    for (const StageEstimate& stage : estimate.stages)
        CHECK(stage.notes.empty());
}

TEST_CASE("What earlier runs measured goes before formulas, for later stages too", "[estimate]")
{
    const Scanned folder;
    const Catalog catalog = hand_made_catalog();
    const PipelineResult result = check(folder, stages, catalog);
    REQUIRE(lines(result).empty());
    MeasuredCost scan;
    scan.frames = 100;
    MeasuredCost frames;
    frames.seconds = 7;
    frames.frames = 10;
    const PipelineEstimate estimate = estimate_pipeline(result.pipeline, 1, {{"scan", scan}, {"frames", frames}, {"other", {}}});
    CHECK(*of(estimate, "scan").seconds == Approx(2));
    CHECK_FALSE(of(estimate, "scan").measured);
    CHECK(of(estimate, "frames").seconds == 7.0);
    CHECK(of(estimate, "frames").measured);
    CHECK(*of(estimate, "frames").memory_mb == 40);
    CHECK(of(estimate, "texture").seconds == 10.0);
}

TEST_CASE("Unknown frames and faces are assumed, and that is said where it matters", "[estimate]")
{
    const Scanned folder;
    const Catalog catalog = hand_made_catalog();
    const PipelineResult result = check(folder, R"(version: 1
stages:
  mesh: {type: mesh.decimate, input: {file: room.ply}}
  next: {type: mesh.pass, input: mesh}
)",
                                        catalog);
    REQUIRE(lines(result).empty());
    const PipelineEstimate estimate = estimate_pipeline(result.pipeline, 1);
    CHECK(*of(estimate, "mesh").seconds == 1);
    REQUIRE(of(estimate, "mesh").notes.size() == 1);
    CHECK(of(estimate, "mesh").notes[0] == "1000000 faces assumed: no input says how many");
    CHECK(of(estimate, "mesh").faces == 500'000.0);
    // A type without a cost costs nothing and assumes nothing.
    CHECK(of(estimate, "next").seconds == 0.0);
    CHECK(of(estimate, "next").notes.empty());
}

TEST_CASE("A formula that fails is a note, not a figure", "[estimate]")
{
    const TemporaryFolder folder;
    Catalog catalog;
    catalog.add(described("odd.stage", "stage", R"json({
        "options": [{"name": "steps", "kind": "int", "default": 0}, {"name": "fast", "kind": "bool", "default": true}],
        "inputs": [], "outputs": [],
        "cost": {"seconds": "1 / steps", "memory_mb": "stepz", "disk_mb": "-5 * fast", "frames": "1e308 * 10", "faces": ""}})json"));
    const PipelineResult result = check(folder, "version: 1\nstages: {a: {type: odd.stage}}\n", catalog);
    REQUIRE(lines(result).empty());
    const PipelineEstimate estimate = estimate_pipeline(result.pipeline, 0);
    const StageEstimate& stage = of(estimate, "a");
    CHECK_FALSE(stage.seconds.has_value());
    CHECK_FALSE(stage.memory_mb.has_value());
    CHECK_FALSE(stage.frames.has_value());
    CHECK(stage.disk_mb == 0.0);
    CHECK_FALSE(estimate.complete);
    REQUIRE(stage.notes.size() == 3);
    CHECK_THAT(stage.notes[0], Catch::StartsWith("frames cannot be estimated:") && Catch::Contains("larger than any number"));
    CHECK_THAT(stage.notes[1], Catch::StartsWith("seconds cannot be estimated:") && Catch::Contains("division by zero"));
    CHECK_THAT(stage.notes[2], Catch::Contains("'stepz' is no name"));
}

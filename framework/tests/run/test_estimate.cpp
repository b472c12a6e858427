#include "catch.h"
#include "hand_made_catalog.h"

#include "run/plan.h"
#include <fresco/error.h>
#include <fresco/frames.h>
#include <fresco/texture.h>

#include <limits>

using namespace fresco;
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
        write("pic.jpg", jpeg_text);
        write("room.ply", ply_text);
    }
};

const std::string stages = R"(version: 1
stages:
  scan:    {type: scan.folder, path: scan, every: 2}
  frames:  {type: frames.sharpest, input: scan}
  mesh:    {type: mesh.decimate,   input: scan, max_faces: 50}
  uvmaps:  {type: uvmaps.raycast,  input: {mesh: mesh, frames: frames}, heights_px: [100, 200]}
  texture: {type: texture.optimize, input: {maps: uvmaps, frames: frames, style: {file: pic.jpg}}, size_px: 1000}
  gltf:    {type: export.gltf, input: texture}
)";

PipelineEstimate estimated(const TemporaryFolder& folder, const std::string& text, const Sets& sets = {}, int cores = 2)
{
    const PipelineResult result = check(folder, text, usual_catalog(), sets);
    REQUIRE(lines(result).empty());
    return estimate_pipeline(result.pipeline, cores);
}

void expect(const PipelineEstimate& estimate, const std::string& stage, double seconds, double memory_mb, double disk_mb)
{
    INFO(stage);
    const CostFigures& figures = estimate.stages.at(stage);
    CHECK(figures.seconds == Approx(seconds));
    CHECK(figures.memory_mb == Approx(memory_mb));
    CHECK(figures.disk_mb == Approx(disk_mb));
}
}  // namespace

TEST_CASE("Costs follow the sizes along the wires", "[estimate]")
{
    const Scanned folder;
    const PipelineEstimate estimate = estimated(folder, stages);
    const double pixels = (100. * 100 + 200. * 200) * 4 / 3;
    // A stage without inputs counts by what it makes.
    expect(estimate, "scan", 1.03, 50, 1);
    expect(estimate, "frames", 0.02 * 3 / 2, 20 + 2 * 10, 0);
    // What comes in takes time, what goes out takes room.
    expect(estimate, "mesh", 200 * 1e-6, 100 + 200 * 1e-4, 50 * 1e-4);
    // Time is of every frame's pixels, memory of one frame's.
    expect(estimate, "uvmaps", 3 * pixels * 1e-6, pixels * 1e-3, 3);
    // Six steps, each on the pixels of the wired uv maps.
    expect(estimate, "texture", 1 + 6 + 6 * pixels * 1e-6, 1, 1);
    expect(estimate, "gltf", 1, 1, 5);
    CHECK(estimate.notes.empty());
    CHECK(estimated(folder, stages, {}, 1).stages.at("frames").seconds == Approx(0.06));
    CHECK(estimated(folder, stages, {{"texture.max_steps", "4"}}).stages.at("texture").seconds ==
          Approx(1 + 4 + 4 * pixels * 1e-6));
}

TEST_CASE("An atlas carries the texture's size to what paints", "[estimate]")
{
    const Scanned folder;
    const std::string text = R"(version: 1
stages:
  scan:  {type: scan.folder, path: scan}
  atlas: {type: atlas.flat, input: scan, size_px: 3000}
  maps:  {type: uvmaps.raycast, input: {mesh: atlas, frames: scan}}
  texture: {type: texture.optimize, input: {maps: maps, frames: scan, style: {file: pic.jpg}}, size_px: 0}
)";
    CHECK(estimated(folder, text).stages.at("texture").memory_mb == Approx(9));
    CHECK(estimated(folder, text, {{"texture.size_px", "1000"}}).stages.at("texture").memory_mb == Approx(1));
}

TEST_CASE("Unknown sizes are assumed, and that is said where it matters", "[estimate]")
{
    const Scanned folder;
    const PipelineEstimate estimate = estimated(folder, R"(version: 1
stages:
  mesh: {type: mesh.decimate, input: {file: room.ply}}
  next: {type: mesh.pass, input: mesh}
  last: {type: mesh.decimate, input: next}
)");
    CHECK(estimate.notes == std::vector<std::string>{"mesh: 1000000 faces assumed: no input says how many"});
    expect(estimate, "mesh", 1, 200, 50);
    // A type without a cost of its own passes sizes on.
    expect(estimate, "next", 0, 20, 0);
    expect(estimate, "last", 0.5, 150, 50);
    // So are those of a recording without a mesh.
    std::filesystem::remove(folder.path() / "scan/mesh.ply");
    const PipelineEstimate recorded = estimated(folder, R"(version: 1
stages:
  scan: {type: scan.folder, path: scan}
  mesh: {type: mesh.decimate, input: scan}
)");
    CHECK(recorded.notes == estimate.notes);
    expect(recorded, "mesh", 1, 200, 50);
}

TEST_CASE("A cost that does not fit its stage is refused", "[estimate]")
{
    const Value options = parse_json(R"([{"name": "path", "kind": "input_folder"}, {"name": "size_px", "kind": "int"},
                                         {"name": "heights_px", "kind": "ints"}])");
    const auto refusal = [&](const Cost& cost)
    { return fresco::testing::error_of([&] { describe_cost("odd.stage", cost, options); }); };
    CHECK(refusal({.makes = {{count::frames, {.files = "path"}},
                             {count::texels, {.squares_of = "size_px"}},
                             {count::pixels, {.squares_of = "heights_px"}}},
                   .steps = {.option = "size_px"}})
              .empty());
    for (const auto& [cost, words] : std::vector<std::pair<Cost, std::string>>{
             {{.makes = {{count::frames, {.option = "sise_px"}}}}, "odd.stage: cost(): the stage has no option \"sise_px\""},
             {{.makes = {{count::faces, {.at_most = "none"}}}}, "\"none\""},
             {{.makes = {{count::texels, {.squares_of = "none"}}}}, "\"none\""},
             {{.makes = {{count::pixels, {.times = {"none"}}}}}, "\"none\""},
             {{.steps = {.number = 1, .divided_by = {"size_px", "none"}}}, "\"none\""},
             {{.makes = {{count::faces, {.files = "size_px"}}}}, "\"size_px\", whose kind is int"},
             {{.makes = {{count::faces, {.option = "heights_px"}}}}, "whose kind is ints"},
             {{.seconds = {.per = {{count::faces, -1}}}}, "faces is -1"},
             {{.seconds = {.per_step = 1}}, "how many steps"},
             {{.disk_mb = {.fixed = std::numeric_limits<double>::infinity()}}, "fixed is"},
             {{.parallel_share = 1.5}, "parallel_share is 1.5"},
             {{.device = "where"}, "the stage has no option \"where\""},
             {{.device = "size_px"}, "the device cannot be read from the option \"size_px\""}})
        CHECK_THAT(refusal(cost), Catch::Contains(words));
}

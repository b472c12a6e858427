#include "catch.h"
#include "room_pipeline.h"

using namespace fresco::host;
using namespace fresco::host::testing;

TEST_CASE("A pipeline file can build on another", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    folder.write("presets/room.yaml", room);
    folder.write("presets/scan/a.png", "1");
    folder.write("presets/pic.jpg", jpeg_text);
    const PipelineResult result = check(folder, R"(version: 1
base: presets/room.yaml
vars: {picture: pic.jpg, faces: 9}
stages:
  mesh:    {max_faces: "${faces}"}
  frames:  {type: mesh.pass, title: new}
  uvmaps:  {input: {frames: scan}, heights_px: [99]}
  glb:
  texture: {input: {frames: scan}, losses: {c: {type: loss.content}}}
  extra:   {type: mesh.pass, input: mesh}
)",
                                        catalog);
    // frames.sharpest gave way to a type that takes a mesh, and still gets the scan.
    REQUIRE(lines(result).empty());
    CHECK(names_of(result) == std::vector<std::string>{"scan", "frames", "mesh", "uvmaps", "texture", "extra"});
    CHECK(options_of(result, "mesh") == R"({"max_faces":9,"keep_borders":true,"method":"quadric"})");
    CHECK(options_of(result, "frames") == R"({"title":"new","size":1.0})");
    CHECK(result.pipeline.find("frames")->wires.at(0).from_port == "mesh");
    CHECK(result.pipeline.find("uvmaps")->wires.at(0).from_stage == "mesh");
    CHECK(result.pipeline.find("uvmaps")->wires.at(1).from_stage == "scan");
    // The var of this file counts from this file, the base's from the base.
    CHECK(result.pipeline.find("texture")->wires.at(2).file == folder.path() / "pic.jpg");
    CHECK(result.pipeline.find("scan")->options->at("path").as_string() == (folder.path() / "presets/scan").string());
    CHECK(result.pipeline.find("mesh")->position.line == 5);
    CHECK(result.pipeline.find("scan")->position.file == "presets/room.yaml");

    folder.write("presets/bad.yaml", "version: 1\nstages:\n  mesh: {type: mesh.decimat}\n");
    const auto bad =
        lines(check(folder, "version: 1\nbase: presets/bad.yaml\nstages:\n  other: {type: mesh.pas}\n  gone:\n", catalog));
    REQUIRE(bad.size() == 3);
    CHECK_THAT(bad[0], Catch::StartsWith("p.yaml:4:17: error: stage 'other': unknown type 'mesh.pas'"));
    CHECK_THAT(bad[1], Catch::StartsWith("p.yaml:5:3: error: an empty value removes"));
    CHECK_THAT(bad[2], Catch::StartsWith("presets/bad.yaml:3:16: error: stage 'mesh': unknown type"));

    folder.write("a.yaml", "version: 1\nbase: p.yaml\n");
    CHECK_THAT(lines(check(folder, "version: 1\nbase: ./a.yaml\n", catalog)).at(0),
               Catch::Contains("a.yaml:2:7: error: cycle: 'base: p.yaml' leads back"));
    CHECK_THAT(lines(check(folder, "version: 1\nbase: p.yaml\n", catalog)).at(0),
               Catch::StartsWith("p.yaml:2:7: error: cycle: 'base: p.yaml' leads back"));
    const PipelineResult missing = check(folder, "version: 1\nbase: none.yaml\n", catalog);
    CHECK_THAT(lines(missing).at(0), Catch::StartsWith("p.yaml:2:7: error: no such pipeline file '"));
    CHECK(missing.exit_code() == 3);
}

namespace
{
PipelineResult preview_of(const Room& folder, const std::string& text, const Catalog& catalog,
                          const std::vector<std::pair<std::string, std::string>>& sets = {})
{
    folder.write("p.yaml", text);
    return load_pipeline({.file = "p.yaml", .sets = sets, .working_directory = folder.path(), .preview = true}, catalog);
}
}  // namespace

TEST_CASE("A preview changes options of the pipeline and of its bases, and --set goes before it", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    folder.write("small.yaml", R"(version: 1
preview:
  mesh: {max_faces: 10}
  frames: {min_sharpness: 1}
  uvmaps: {heights_px: [16]}
  video: {seconds: 1}
  glb: {path: small.glb}
)");
    folder.write("room.yaml", room + "base: small.yaml\npreview: {texture: {max_steps: 7}}\n");
    const std::string text = R"(version: 1
base: room.yaml
vars: {height: 99}
stages:
  mesh:   {max_faces: 300}
  frames: {type: mesh.pass, input: scan.mesh}
  uvmaps: {input: {frames: scan}}
  texture: {input: {frames: scan}}
  glb:
preview:
  mesh:   {method: edge}
  uvmaps: {heights_px: ["${height}"]}
  texture: {epochs: 1}
)";
    const PipelineResult small = preview_of(folder, text, catalog);
    REQUIRE(lines(small) == std::vector<std::string>{});
    CHECK(options_of(small, "mesh") == R"({"max_faces":10,"keep_borders":true,"method":"edge"})");
    // Another type: the base's options are dropped, those of its preview too. A stage that is not there has none.
    CHECK(options_of(small, "frames") == R"({"title":"","size":1.0})");
    CHECK(names_of(small) == std::vector<std::string>{"scan", "frames", "mesh", "uvmaps", "texture"});
    CHECK_THAT(options_of(small, "uvmaps"), Catch::StartsWith(R"({"heights_px":[99],)"));
    CHECK_THAT(options_of(small, "texture"), Catch::Contains(R"("epochs":1)") && Catch::Contains(R"("max_steps":7)"));

    const PipelineResult set = preview_of(folder, text, catalog, {{"mesh.max_faces", "40"}});
    CHECK(options_of(set, "mesh") == R"({"max_faces":40,"keep_borders":true,"method":"edge"})");
    const PipelineResult full = check(folder, text, catalog);
    CHECK(options_of(full, "mesh") == R"({"max_faces":300,"keep_borders":true,"method":"quadric"})");
    CHECK_THAT(options_of(full, "uvmaps"), Catch::StartsWith(R"({"heights_px":[256,432],)"));
}

TEST_CASE("A preview that a pipeline lacks, or that does not fit it, is refused", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const auto problems = [&](const std::string& text) { return lines(preview_of(folder, text, catalog)); };
    CHECK(problems(room) == std::vector<std::string>{"--preview: error: p.yaml has no 'preview': {STAGE: {OPTION: VALUE}}, the "
                                                     "options that make it fast; 'base: …/presets/preview.yaml' has some"});
    CHECK(lines(check(folder, room, catalog)).empty());

    const auto bad = problems(room + "preview:\n  mesh: {type: mesh.pass}\n  mehs: {max_faces: 9}\n  frames: 3\n  uvmaps: "
                                     "{height: 3}\n  1a: {}\n");
    REQUIRE(bad.size() == 6);
    CHECK(bad[0] == "p.yaml:14:10: error: a preview cannot change the type of a stage");
    CHECK(bad[1] == "p.yaml:15:3: error: unknown stage 'mehs' (did you mean 'mesh'?)");
    CHECK_THAT(bad[2], Catch::StartsWith("p.yaml:16:3: error: the preview of 'frames' must be a map {option: …}, got 3"));
    CHECK_THAT(bad[3], Catch::StartsWith("p.yaml:17:12: error: ") && Catch::Contains("'height'"));
    CHECK_THAT(bad[4], Catch::StartsWith("p.yaml:18:3: error: '1a' cannot name a stage"));
    const auto none = lines(check(folder, "version: 1\npreview: {mesh: {max_faces: 9}}\n", catalog));
    REQUIRE(none.size() == 1);
    CHECK_THAT(none[0], Catch::StartsWith("p.yaml:1:1: error: missing stages"));
}

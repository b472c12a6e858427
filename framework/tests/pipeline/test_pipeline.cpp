#include <catch2/catch.hpp>

#include "hand_made_catalog.h"

#include <fresco/error.h>
#include <fresco/input_roots.h>

using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{
const std::string room = R"(version: 1
vars: {data: scan, picture: pic.jpg, weights: ""}
stages:
  glb:     {type: export.gltf, input: texture, path: room.glb}
  scan:    {type: scan.folder, path: "${data}"}
  frames:  {type: frames.sharpest, input: scan, min_sharpness: 150}
  mesh:    {type: mesh.decimate,   input: scan, max_faces: 400000}
  uvmaps:  {type: uvmaps.raycast,  input: {mesh: mesh, frames: frames}, heights_px: [256, 432]}
  texture:
    type: texture.optimize
    input: {maps: uvmaps, frames: frames, style: {file: "${picture}"}}
    weights: "${weights}"
)";

/// A folder with what the pipelines of these tests name.
struct Room : TemporaryFolder
{
    Room()
    {
        write("scan/a.png", "1");
        write("pic.jpg", jpeg_text);
        write("vgg.st", "1");
    }
};

std::string options_of(const PipelineResult& result, const char* stage)
{
    const PipelineStage* found = result.pipeline.find(stage);
    return found ? fresco::to_json(*found->options) : "no stage";
}

std::vector<std::string> names_of(const PipelineResult& result)
{
    std::vector<std::string> names;
    for (const PipelineStage& stage : result.pipeline.stages)
        names.push_back(stage.name);
    return names;
}

/// By the inputs of the pipeline.
std::string input_name_of(const PipelineResult& result, const std::filesystem::path& file)
{
    fresco::set_input_roots(result.pipeline.inputs);
    std::string name = fresco::input_name(file);
    fresco::set_input_roots({});
    return name;
}
}  // namespace

TEST_CASE("A pipeline is completed down to the options of its components", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const PipelineResult result = check(folder, room, catalog);
    REQUIRE(lines(result).empty());
    CHECK(result.exit_code() == 0);
    CHECK(result.pipeline.file == folder.path() / "p.yaml");
    CHECK(names_of(result) == std::vector<std::string>{"scan", "frames", "mesh", "uvmaps", "texture", "glb"});
    CHECK(options_of(result, "mesh") == R"({"max_faces":400000,"keep_borders":true,"method":"quadric"})");
    // A whole number for a number is a number: 150 and 150.0 are one cache key.
    CHECK(options_of(result, "frames") == R"({"min_sharpness":150.0})");
    CHECK(options_of(result, "scan") == R"({"path":")" + (folder.path() / "scan").string() + R"(","every":1})");
    // An empty output name and an optional slot are left out; `auto` follows the empty weights.
    CHECK(
        options_of(result, "texture") ==
        R"({"size_px":2048,"epochs":2,"max_steps":0,"weights":"","losses":{"style":{"type":"loss.gram","weight":2.0,"features":{"type":"features.edges","seed":1}}}})");

    const PipelineStage& texture = *result.pipeline.find("texture");
    REQUIRE(texture.wires.size() == 3);
    CHECK(texture.wires[0].port == "maps");
    CHECK(texture.wires[0].from_stage == "uvmaps");
    CHECK(texture.wires[0].from_port == "maps");
    CHECK(texture.wires[1].from_port == "kept");
    CHECK(texture.wires[2].from_stage.empty());
    CHECK(texture.wires[2].artifact == "image");
    CHECK(texture.wires[2].file == folder.path() / "pic.jpg");
    CHECK(fresco::to_json(texture.wires[2].reader) == R"({"type":"read.image","max_px":100})");
    CHECK(texture.input_files == std::vector<std::filesystem::path>{folder.path() / "pic.jpg"});
    std::vector<std::string> components;
    for (const TypeDescription* component : texture.components)
        components.push_back(component->type);
    CHECK(components == std::vector<std::string>{"features.edges", "loss.gram", "read.image"});
    CHECK(texture.type == catalog.find("texture.optimize"));
    CHECK(texture.position.line == 9);
    CHECK(texture.position.column == 3);
    CHECK(result.pipeline.find("scan")->wires.empty());
}

TEST_CASE("auto follows the option that decides it", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const PipelineResult result = check(folder, room, catalog, {{"weights", "vgg.st"}});
    REQUIRE(lines(result).empty());
    const std::string weights = (folder.path() / "vgg.st").string();
    CHECK(options_of(result, "texture") ==
          R"({"size_px":2048,"epochs":2,"max_steps":0,"weights":")" + weights +
              R"(","losses":{"content":{"type":"loss.content","weight":70.0},)" +
              R"("style":{"type":"loss.gram","weight":1.0,"features":{"type":"features.vgg","weights":")" + weights + R"("}}}})");
    const PipelineStage& texture = *result.pipeline.find("texture");
    CHECK(texture.input_files == std::vector<std::filesystem::path>{folder.path() / "pic.jpg", folder.path() / "vgg.st"});
}

TEST_CASE("Components are written as a type, with or without options, in any order", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const auto losses = [&](const std::string& text) { return check(folder, room + "    losses: " + text + "\n", catalog); };
    const std::string by_word =
        options_of(losses("{b: loss.content, a: {type: loss.gram, features: features.edges}}"), "texture");
    const std::string in_full = options_of(
        losses("{a: {features: {seed: 1, type: features.edges}, weight: 1, type: loss.gram}, b: {type: loss.content}}"),
        "texture");
    CHECK(by_word == in_full);
    CHECK(by_word.find(R"("losses":{"a":{"type":"loss.gram","weight":1.0,"features":)") != std::string::npos);
    CHECK(options_of(losses("{}"), "texture").find(R"("losses":{})") != std::string::npos);
    CHECK(options_of(losses("auto"), "texture") == options_of(check(folder, room, catalog), "texture"));
}

TEST_CASE("none leaves a slot empty that may be, whatever its default", "[pipeline]")
{
    const TemporaryFolder folder;
    const Catalog catalog = hand_made_catalog();
    const auto judged = [&](const std::string& options, const Sets& sets = {})
    {
        const PipelineResult result =
            check(folder, "version: 1\nstages: {a: {type: mesh.judged" + options + "}}\n", catalog, sets);
        return result.problems.empty() ? options_of(result, "a") : lines(result).front();
    };
    const std::string needed = R"("needed":{"type":"loss.content","weight":70.0}})";
    CHECK(judged("") == R"({"loss":{"type":"loss.content","weight":70.0},)" + needed);
    CHECK(judged(", loss: none") == "{" + needed);
    CHECK(judged("", {{"a.loss", "none"}}) == "{" + needed);
    CHECK_THAT(judged(", needed: none"), Catch::Contains("unknown type 'none' (there are: loss.content, loss.gram)"));
    CHECK_THAT(judged(", loss: [1]"), Catch::Contains("expected {type: …} of kind 'loss', or none, got a list"));
}

TEST_CASE("Ports may be named, outputs too, and an empty file leaves an optional one open", "[pipeline]")
{
    const Room folder;
    folder.write("m.ply", ply_text);
    const Catalog catalog = hand_made_catalog();
    const PipelineResult result = check(folder, R"(version: 1
stages:
  two:  {type: mesh.two}
  a:    {type: mesh.pass, input: two.left}
  b:    {type: mesh.pass, input: {mesh: two.right}}
  c:    {type: mesh.pass, input: {file: m.ply}}
  d:    {type: mesh.pass, input: {mesh: {file: "", type: read.mesh}}}
  e:    {type: mesh.pass}
)",
                                        catalog);
    REQUIRE(lines(result).empty());
    CHECK(result.pipeline.find("a")->wires.at(0).from_port == "left");
    CHECK(result.pipeline.find("b")->wires.at(0).from_port == "right");
    CHECK(result.pipeline.find("c")->wires.at(0).file == folder.path() / "m.ply");
    CHECK(result.pipeline.find("d")->wires.empty());
    CHECK(result.pipeline.find("e")->wires.empty());
}

TEST_CASE("A stage's name wires every input that one of its outputs fits in one way", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const PipelineResult result = check(folder, R"(version: 1
stages:
  scan:   {type: scan.folder, path: .}
  kept:   {type: frames.sharpest, input: scan}
  uvmaps: {type: uvmaps.raycast, input: scan}
)",
                                        catalog);
    REQUIRE(lines(result).empty());
    const auto& wires = result.pipeline.find("uvmaps")->wires;
    REQUIRE(wires.size() == 2);
    CHECK((wires[0].port == "mesh" && wires[0].from_stage == "scan" && wires[0].from_port == "mesh"));
    CHECK((wires[1].port == "frames" && wires[1].from_stage == "scan" && wires[1].from_port == "frames"));
    CHECK(result.pipeline.find("kept")->wires.size() == 1);
}

TEST_CASE("A diamond and several sinks keep the file's order", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const PipelineResult result = check(folder, R"(version: 1
stages:
  sink1: {type: mesh.pass, input: right}
  left:  {type: mesh.decimate, input: top}
  top:   {type: mesh.pass}
  right: {type: mesh.decimate, input: top}
  sink2: {type: mesh.pass, input: left}
)",
                                        catalog);
    REQUIRE(lines(result).empty());
    CHECK(names_of(result) == std::vector<std::string>{"top", "left", "right", "sink1", "sink2"});
}

TEST_CASE("Vars keep their type, and paths count from where they were written", "[pipeline]")
{
    const Room folder;
    folder.write("sub/scan/x.png", "1");
    folder.write("work/other/y.png", "1");
    const Catalog catalog = hand_made_catalog();
    folder.write("sub/p.yaml", R"(version: 1
vars: {root: scan, faces: 1000, heights: [16, 32], deep: "${root}", name: room}
stages:
  scan:   {type: scan.folder, path: "${deep}"}
  mesh:   {type: mesh.decimate, input: scan, max_faces: "${faces}"}
  uv:     {type: uvmaps.raycast, input: {mesh: mesh, frames: scan}, heights_px: "${heights}"}
  again:  {type: scan.folder, path: "${root}/../${root}"}
  note:   {type: mesh.pass, title: "${name}s of $${name} cost 5$"}
)");
    const auto load = [&](const Sets& sets) {
        return load_pipeline({folder.path() / "sub/p.yaml", sets, folder.path() / "work"}, catalog);
    };
    const PipelineResult result = load({});
    REQUIRE(lines(result).empty());
    CHECK(options_of(result, "scan").find((folder.path() / "sub/scan").string()) != std::string::npos);
    CHECK(result.pipeline.find("mesh")->options->at("max_faces") == fresco::Value(1000));
    CHECK(fresco::to_json(result.pipeline.find("uv")->options->at("heights_px")) == "[16,32]");
    CHECK(result.pipeline.find("note")->options->at("title").as_string() == "rooms of ${name} cost 5$");

    const PipelineResult set = load({{"root", "other"}, {"faces", "7"}, {"heights", "[64]"}, {"note.title", "${name}: 010"}});
    REQUIRE(lines(set).empty());
    CHECK(set.pipeline.find("scan")->options->at("path").as_string() == (folder.path() / "work/other").string());
    CHECK(set.pipeline.find("again")->options->at("path").as_string() == (folder.path() / "work/other").string());
    CHECK(result.pipeline.find("again")->options->at("path").as_string() == (folder.path() / "sub/scan").string());
    CHECK(set.pipeline.find("mesh")->options->at("max_faces") == fresco::Value(7));
    CHECK(fresco::to_json(set.pipeline.find("uv")->options->at("heights_px")) == "[64]");
    CHECK(set.pipeline.find("note")->options->at("title").as_string() == "room: 010");
    // A path given to an option on the command line counts from the working directory; one in the file from the file's folder.
    CHECK(lines(load({{"scan.path", "other"}})).empty());
    CHECK_FALSE(lines(load({{"scan.path", "scan"}})).empty());
}

TEST_CASE("--set reaches into components, also those that are only defaults", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const auto texture = [&](const Sets& sets)
    {
        const PipelineResult result = check(folder, room, catalog, sets);
        return result.problems.empty() ? options_of(result, "texture") : lines(result).front();
    };
    CHECK_THAT(texture({{"texture.losses.style.weight", "5"}}), Catch::Contains(R"("style":{"type":"loss.gram","weight":5.0)"));
    CHECK_THAT(texture({{"texture.losses.style.features.seed", "9"}}), Catch::Contains(R"({"type":"features.edges","seed":9})"));
    // What decides `auto` is in place first, whatever the order.
    CHECK_THAT(texture({{"texture.losses.content.weight", "3"}, {"texture.weights", "vgg.st"}}),
               Catch::Contains(R"("content":{"type":"loss.content","weight":3.0})"));
    CHECK_THAT(texture({{"texture.losses.more.type", "loss.content"}, {"texture.losses.more.weight", "4"}}),
               Catch::Contains(R"("more":{"type":"loss.content","weight":4.0},"style")"));
    CHECK_THAT(texture({{"texture.losses", "{one: {type: loss.content, weight: 1}}"}}),
               Catch::Contains(R"("losses":{"one":{"type":"loss.content","weight":1.0}}})"));
    // Another type takes nothing over from the old one's options.
    CHECK_THAT(texture({{"texture.losses.style.features.seed", "9"}, {"texture.losses.style.type", "loss.content"}}),
               Catch::Contains(R"("style":{"type":"loss.content","weight":70.0})"));
    CHECK_THAT(texture({{"texture.losses.stile.weight", "5"}}),
               Catch::Contains("there is no 'texture.losses.stile' (did you mean 'style'?)"));
    CHECK_THAT(texture({{"texture.losses.style.wieght", "5"}}),
               Catch::Contains("has no option 'wieght' (did you mean 'weight'?)"));
    CHECK_THAT(texture({{"texture.size_px.deep", "5"}}), Catch::Contains("'texture.size_px' is not a component"));
    CHECK_THAT(texture({{"texture.rule.speed", "5"}}), Catch::Contains("holds no component yet"));
    CHECK_THAT(texture({{"texture.lozzes.style.weight", "5"}}),
               Catch::Contains("has no option 'lozzes' (did you mean 'losses'?)"));

    const PipelineResult wired = check(folder, room, catalog, {{"uvmaps.input.mesh", "scan"}, {"mesh.type", "mesh.pass"}});
    REQUIRE(lines(wired).empty());
    CHECK(wired.pipeline.find("uvmaps")->wires.at(0).from_stage == "scan");
    // The input stays when a stage's type changes, its options go.
    CHECK(wired.pipeline.find("mesh")->wires.at(0).from_stage == "scan");
    CHECK(options_of(wired, "mesh") == R"({"title":"","size":1.0})");
    const PipelineResult file = check(folder, room, catalog, {{"texture.input.style.file", "vgg.st"}});
    CHECK_THAT(lines(file).at(0), Catch::Contains("no reader makes image from '.st' files (there are: .jpg, .png)"));
}

TEST_CASE("--set of what does not exist is an error with the nearest spelling", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const auto problem = [&](const std::string& name, const std::string& value)
    {
        const PipelineResult result = check(folder, room, catalog, {{name, value}});
        return result.problems.size() == 1 ? lines(result)[0]
                                           : "there are " + std::to_string(result.problems.size()) + " problems";
    };
    CHECK(problem("dat", "x") == "--set dat=x: error: unknown var 'dat' in the pipeline (did you mean 'data'?)");
    CHECK_THAT(problem("mesh", "x"), Catch::Contains("'mesh' is a stage"));
    CHECK_THAT(problem("mehs.max_faces", "5"), Catch::Contains("unknown stage 'mehs' (did you mean 'mesh'?)"));
    CHECK_THAT(problem("mesh.max_face", "5"), Catch::Contains("has no option 'max_face' (did you mean 'max_faces'?)"));
    CHECK_THAT(problem("mesh.max_faces", "3"), Catch::Contains("3 is too small; expected an integer from 4 to 50000000"));
    CHECK_THAT(problem("mesh.max_faces", "[1"), Catch::Contains("--set mesh.max_faces=[1: error: a '[' is not closed"));
    CHECK_THAT(problem("mesh..x", "1"), Catch::Contains("expected NAME=VALUE"));
    CHECK_THAT(problem("uvmaps.heights_px", "64"), Catch::Contains("(write [64])"));
    CHECK(problem("picture", "no.jpg").find("--set") == std::string::npos);
    CHECK_THAT(problem("picture", "no.jpg"), Catch::Contains("p.yaml:11:57: error:") && Catch::Contains("no such file '"));
}

TEST_CASE("An input is a var whose folder is known to the pipeline", "[pipeline]")
{
    const Room folder;
    const Catalog catalog = hand_made_catalog();
    const std::string stages = "stages:\n  scan: {type: scan.folder, path: \"${data}/scan\"}\n";
    const PipelineResult result = check(folder, "version: 1\ninputs: {data: ., other: }\n" + stages, catalog);
    REQUIRE(lines(result).empty());
    CHECK(result.pipeline.find("scan")->options->at("path").as_string() == (folder.path() / "scan").string());
    CHECK(input_name_of(result, folder.path() / "scan") == "input:data/scan");
    CHECK(input_name_of(result, folder.path()) == "input:data");
    folder.write("moved/scan/a.png", "1");
    const PipelineResult moved = check(folder, "version: 1\ninputs: {data: ., other: }\n" + stages, catalog,
                                       {{"data", (folder.path() / "moved").string()}});
    REQUIRE(lines(moved).empty());
    CHECK(input_name_of(moved, folder.path() / "moved/scan") == "input:data/scan");

    const auto problem = [&](const std::string& text)
    { return lines(check(folder, "version: 1\n" + text + stages, catalog)).at(0); };
    CHECK_THAT(problem("vars: {data: .}\ninputs: {data: .}\n"),
               Catch::Contains("p.yaml:3:10: error: 'data' is under 'vars', too"));
    CHECK_THAT(problem("inputs: {data: [a, b]}\n"), Catch::Contains("must be the path of one folder, got a list"));
    CHECK_THAT(problem("inputs: {data: }\nmatrix: {data: [a, b]}\n"), Catch::Contains("got the values of an axis"));
    CHECK_THAT(problem("inputs: {data: }\n"), Catch::Contains("the var 'data' has no value"));
}

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

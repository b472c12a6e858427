#include "catch.h"
#include "room_pipeline.h"

#include <fresco/error.h>
#include <fresco/file_access.h>

using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{
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

#include "catch.h"
#include "hand_made_catalog.h"
#include "schema_check.h"

#include "pipeline/schema.h"

using namespace fresco::host;
using namespace fresco::host::testing;
using fresco::Value;

namespace
{

/// Stages that make regions, of known names and of others, and one that has rules for them.
Catalog with_rules()
{
    Catalog catalog = hand_made_catalog();
    const auto makes = [&](const std::string& type, const std::string& output)
    { catalog.add(described(type, "stage", R"({"options": [], "inputs": [], "outputs": [{)" + output + R"(, "help": ""}]})")); };
    makes("regions.planes", R"("name": "regions", "artifact": "regions", "version": 1, "parts": ["floor", "walls", "ceiling"])");
    makes("regions.files", R"("name": "regions", "artifact": "regions", "version": 1)");
    makes("texture.paint", R"("name": "texture", "artifact": "texture", "version": 2)");
    catalog.add(described("texture.regions", "stage", R"json({
        "options": [{"name": "regions", "kind": "rules", "required": true, "help": "",
                     "rule": {"parts_of": "regions", "word": "keep", "input": "texture", "artifact": "texture", "version": 2, "number": "strength"}}],
        "inputs": [{"name": "photo", "artifact": "texture", "version": 2, "help": ""},
                   {"name": "regions", "artifact": "regions", "version": 1, "help": ""}],
        "outputs": [{"name": "texture", "artifact": "texture", "version": 2, "help": ""}]})json"));
    return catalog;
}

constexpr const char* before = R"(version: 1
vars: {rules: {floor: keep}}
stages:
  planes: {type: regions.planes}
  files: {type: regions.files}
  photo: {type: texture.paint}
  night: {type: texture.paint}
  )";

PipelineResult with_stage(const TemporaryFolder& folder, const std::string& stage)
{
    return check(folder, before + stage + "\n", with_rules());
}

std::string problem_with_rules(const std::string& stage)
{
    const TemporaryFolder folder;
    std::string joined;
    for (const std::string& line : lines(with_stage(folder, stage)))
        joined += (joined.empty() ? "" : " | ") + line;
    return joined;
}

}  // namespace

TEST_CASE("The textures that rules name are inputs of their stage", "[pipeline]")
{
    const TemporaryFolder folder;
    const PipelineResult result =
        with_stage(folder, "m: {type: texture.regions, input: {photo: photo, regions: planes, dark: night}, "
                           "regions: {floor: keep, '*': {texture: dark, strength: 0.5}}}");
    CHECK(lines(result).empty());
    REQUIRE(!result.pipeline.stages.empty());
    const PipelineStage& stage = result.pipeline.stages.back();
    REQUIRE(stage.wires.size() == 3);
    CHECK(stage.wires[2].port == "dark");
    CHECK(stage.wires[2].from_stage == "night");
    CHECK(fresco::to_json(stage.options->at("regions")) ==
          R"({"*":{"texture":"dark","strength":0.5},"floor":{"texture":"keep","strength":1.0}})");
}

TEST_CASE("Rules for what there is not are refused before a run, with their place", "[pipeline]")
{
    const std::string wired = "m: {type: texture.regions, input: {photo: photo, regions: planes, dark: night}, regions: ";
    CHECK(problem_with_rules(wired + "{flor: keep, walls: dark}}") ==
          "p.yaml:8:93: error: stage 'm' (texture.regions): option "
          "'regions': stage 'planes' (regions.planes) makes no 'flor' (did "
          "you mean 'floor'?)");
    CHECK(problem_with_rules(wired + "{floor: keep, floor: dark}}") ==
          "p.yaml:8:69: error: stage 'm' (texture.regions) has no input 'dark' (there are: photo, regions) | p.yaml:8:106: "
          "error: the key 'floor' appears twice; the first is on line 8");
    CHECK(problem_with_rules(wired + "{floor: dusk, walls: dark}}") ==
          "p.yaml:8:30: error: stage 'm' (texture.regions) needs the input 'dusk' (texture (version 2)); it is made by "
          "photo.texture and night.texture");
    CHECK(problem_with_rules(wired + "{floor: keep}}") ==
          "p.yaml:8:69: error: stage 'm' (texture.regions) has no input 'dark' (there are: "
          "photo, regions)");
    CHECK(problem_with_rules(wired + "{floor: photo, walls: dark}}") ==
          "p.yaml:8:93: error: stage 'm' (texture.regions): option 'regions': 'photo' is another input of the stage; expected "
          "keep, or a texture of another name");
    CHECK(problem_with_rules(wired + "{floor: {texture: dark, strength: 2}}}") ==
          "p.yaml:8:126: error: stage 'm' (texture.regions): option 'regions': expected a number from 0 to 1 for 'strength' of "
          "'floor', got 2");
    // Names that are only known when the stage has run.
    CHECK(problem_with_rules(
              "m: {type: texture.regions, input: {photo: photo, regions: files, dark: night}, regions: {flor: dark}}")
              .empty());
}

TEST_CASE("The editor schema knows rules", "[schema]")
{
    const Value schema = pipeline_schema(with_rules());
    const SchemaCheck check(schema);
    const auto accepts = [&](const Value& rules)
    {
        return check.accepts(Value::Map{
            {"version", 1}, {"stages", Value::Map{{"m", Value::Map{{"type", "texture.regions"}, {"regions", rules}}}}}});
    };
    CHECK(accepts(Value::Map{{"floor", "keep"}, {"*", Value::Map{{"texture", "dark"}, {"strength", 0.5}}}}));
    CHECK(!accepts(Value::Map{}));
    CHECK(!accepts("keep"));
    CHECK(!accepts(Value::Map{{"floor", Value::Map{{"texture", "dark"}, {"strength", 1.5}}}}));
    CHECK(!accepts(Value::Map{{"floor", Value::Map{{"strength", 0.5}}}}));
}

TEST_CASE("Rules are checked for every combination", "[pipeline]")
{
    const std::string matrix = "matrix: {rules: {a: {floor: keep}, b: {roof: keep}}}\n";
    const TemporaryFolder folder;
    std::string joined;
    for (const std::string& line : lines(with_stage(
             folder, "m: {type: texture.regions, input: {photo: photo, regions: planes}, regions: '${rules}'}\n" + matrix)))
        joined += line;
    CHECK_THAT(joined, Catch::Contains("stage 'planes' (regions.planes) makes no 'roof'") && Catch::Contains("(with rules 'b')"));
}

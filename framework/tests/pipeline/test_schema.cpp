#include "catch.h"
#include "hand_made_catalog.h"

#include "pipeline/schema.h"

// The editor schema, which tests/pipelines holds against pipelines, and rules for parts.

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
    makes("regions.planes",
          R"("name": "regions", "artifact": "regions", "version": 1, "parts": ["floor", "walls", "rest/part_1"])");
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

/// A stage of rules behind two that make regions and two that make textures.
PipelineResult ruled(const std::string& inputs, const std::string& rules, const std::string& more = "")
{
    static const TemporaryFolder folder;
    return check(folder,
                 R"(version: 1
vars: {rules: {floor: keep}}
stages:
  planes: {type: regions.planes}
  files: {type: regions.files}
  photo: {type: texture.paint}
  night: {type: texture.paint}
  m: {type: texture.regions, input: {photo: photo, )" +
                     inputs + "}, regions: " + rules + "}\n" + more,
                 with_rules());
}

}  // namespace

TEST_CASE("The editor schema says what every type takes", "[schema]")
{
    const Value schema = pipeline_schema(hand_made_catalog());
    CHECK(fresco::to_json(schema.at("$defs").at("type.mesh.decimate").at("properties").at("max_faces")) ==
          R"json({"anyOf":[{"type":"integer","minimum":4.0,"maximum":5e+07},{"$ref":"#/$defs/var"}],)json"
          R"json("description":"Stop at this many triangles (an integer from 4 to 50000000)","default":500000})json");
}

TEST_CASE("The textures that rules name are inputs of their stage", "[pipeline]")
{
    const PipelineResult result = ruled("regions: planes, dark: night", "{floor: keep, '*': {texture: dark, strength: 0.5}}");
    CHECK(options_of(result, "m") ==
          R"({"regions":{"*":{"texture":"dark","strength":0.5},"floor":{"texture":"keep","strength":1.0}}})");
    const PipelineStage& stage = result.pipeline.stages.back();
    REQUIRE(stage.wires.size() == 3);
    CHECK(stage.wires[2].port == "dark");
    CHECK(stage.wires[2].from_stage == "night");
}

TEST_CASE("Rules that do not fit are refused before a run, with their place", "[pipeline]")
{
    for (const auto& [rules, place, words] : std::vector<std::array<std::string, 3>>{
             {"{flor: keep, walls: dark}", "8:93", "stage 'planes' (regions.planes) makes no 'flor' (did you mean 'floor'?)"},
             {"{part_11: keep, walls: dark}", "8:93", "makes no 'part_11' (did you mean 'part_1'?)"},
             {"{floor: dusk, walls: dark}", "8:93",
              "option 'regions': 'input' has no texture 'dusk' for it (did you mean 'dark'?)"},
             {"{floor: keep, walls: keeep}", "8:106",
              "option 'regions': 'input' has no texture 'keeep' for it (did you mean 'keep'?)"},
             {"{floor: keep}", "8:69", "has no input 'dark' (there are: photo, regions)"},
             {"{floor: photo, walls: dark}", "8:93", "'input' has no texture 'photo' for it (there are: keep, dark)"},
             {"{floor: {texture: dark, strength: 2}}", "8:126", "from 0 to 1 for 'strength' of 'floor', got 2"}})
    {
        CAPTURE(rules);
        CHECK_THAT(joined_lines(ruled("regions: planes, dark: night", rules)),
                   StartsWith("p.yaml:" + place + ": error: stage 'm' (texture.regions)") && Contains(words));
    }
    CHECK(joined_lines(ruled("regions: planes, dark: night", "{part_1: dark, rest/part_1: keep, rest: dark}")).empty());
    // Names that are only known when the stage has run.
    CHECK(joined_lines(ruled("regions: files, dark: night", "{flor: dark}")).empty());
    // For every combination.
    CHECK_THAT(joined_lines(ruled("regions: planes", "'${rules}'", "matrix: {rules: {a: {floor: keep}, b: {roof: keep}}}\n")),
               Contains("makes no 'roof'") && Contains("(with rules 'b')"));
}

#include "catch.h"
#include "hand_made_catalog.h"

#include "pipeline/schema.h"
#include "pipeline/yaml_document.h"

#include <algorithm>
#include <regex>

// The editor schema, and rules for parts: both say what a pipeline may hold.

using namespace fresco::host;
using namespace fresco::host::testing;
using fresco::Value;

namespace
{

/// As much of a JSON Schema validator as these tests need.
class SchemaCheck
{
  public:
    explicit SchemaCheck(const Catalog& catalog) : root_(pipeline_schema(catalog)) {}

    const Value& schema() const { return root_; }
    bool accepts(const Value& value) const { return accepts(root_, value); }

  private:
    static bool has_type(const Value& value, const std::string& type)
    {
        const std::map<std::string, bool> types{{"object", value.is_map()},    {"array", value.is_list()},
                                                {"string", value.is_string()}, {"boolean", value.is_bool()},
                                                {"integer", value.is_int()},   {"number", value.is_number()},
                                                {"null", value.is_null()}};
        return types.at(type);
    }

    bool accepts(const Value& schema, const Value& value) const
    {
        return std::ranges::all_of(schema.as_map(),
                                   [&](const auto& entry) { return obeys(schema, entry.first, entry.second, value); });
    }

    bool obeys(const Value& schema, const std::string& key, const Value& rule, const Value& value) const
    {
        const auto accepted = [&](const Value& way) { return accepts(way, value); };
        const auto each_entry = [&](const auto& fits) { return !value.is_map() || std::ranges::all_of(value.as_map(), fits); };
        if (key == "$ref")
            return accepted(root_.at("$defs").at(rule.as_string().substr(std::string("#/$defs/").size())));
        if (key == "type")
            return has_type(value, rule.as_string());
        if (key == "const")
            return value == rule;
        if (key == "enum")
            return std::ranges::count(rule.as_list(), value) > 0;
        if (key == "minimum")
            return !value.is_number() || value.as_double() >= rule.as_double();
        if (key == "maximum")
            return !value.is_number() || value.as_double() <= rule.as_double();
        if (key == "pattern")
            return !value.is_string() || std::regex_search(value.as_string(), std::regex(rule.as_string()));
        if (key == "anyOf")
            return std::ranges::any_of(rule.as_list(), accepted);
        if (key == "allOf")
            return std::ranges::all_of(rule.as_list(), accepted);
        if (const Value* branch = key == "if" ? schema.find(accepted(rule) ? "then" : "else") : nullptr)
            return accepted(*branch);
        if (key == "items")
            return !value.is_list() ||
                   std::ranges::all_of(value.as_list(), [&](const Value& item) { return accepts(rule, item); });
        if (key == "minItems" || key == "minProperties")
            return !(value.is_list() && value.as_list().empty()) && !(value.is_map() && value.as_map().empty());
        if (key == "required")
            return std::ranges::all_of(rule.as_list(),
                                       [&](const Value& name) { return !value.is_map() || value.find(name.as_string()); });
        if (key == "propertyNames")
            return each_entry([&](const auto& entry) { return accepts(rule, Value(entry.first)); });
        if (key == "properties")
            return each_entry([&](const auto& entry)
                              { return !rule.find(entry.first) || accepts(rule.at(entry.first), entry.second); });
        if (key == "additionalProperties")
        {
            const Value* own = schema.find("properties");
            return each_entry([&](const auto& entry)
                              { return (own && own->find(entry.first)) || (rule.is_map() && accepts(rule, entry.second)); });
        }
        const Words without_effect{"$schema", "$defs", "title", "description", "default", "if", "then", "else", "uniqueItems"};
        if (std::ranges::count(without_effect, key) == 0)
            throw std::runtime_error("the schema has the unknown key " + key);
        return true;
    }

    Value root_;
};

Value value_of(const YamlNode& node)
{
    Value::Map map;
    for (const YamlNode::Entry& entry : node.entries)
        map.emplace_back(entry.key, value_of(entry.value));
    if (node.is_list())
        return each<Value>(node.items, value_of);
    return node.is_map() ? Value(std::move(map)) : node.is_scalar() ? resolve_scalar(node).value : Value();
}

Value yaml(const std::string& text)
{
    ProblemList problems;
    bool complete = false;
    const auto source = std::make_shared<const YamlSource>(YamlSource{"f", "/", false});
    const Value value = value_of(parse_yaml("version: 1\n" + text, source, problems, complete));
    REQUIRE(problems.empty());
    return value;
}

/// Stages that make regions, of known names and of others, and one that has rules for them.
Catalog with_rules()
{
    Catalog catalog = catalog_with_codecs();
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

TEST_CASE("The editor schema accepts what the host accepts and refuses what it refuses", "[schema]")
{
    const SchemaCheck check(with_rules());
    for (const char* good :
         {R"(vars: {data: scan, n: 5}
stages:
  scan:    {type: scan.folder, path: "${data}"}
  mesh:    {type: mesh.decimate, input: scan, max_faces: "${n}"}
  uvmaps:  {type: uvmaps.raster,  input: {mesh: mesh, frames: scan.frames}, heights_px: [256, "${n}"]}
  texture:
    type: texture.optimize
    input: {maps: uvmaps, frames: scan, style: {file: pic.jpg, max_px: 9}}
    losses: {style: {type: loss.gram, weight: 1e-4, features: {type: features.vgg, weights: w}}, c: loss.content}
)",
          "stages: {a: {type: mesh.decimate, input: {file: a.ply}}}", "stages: {a: {type: texture.optimize, losses: auto}}",
          "stages: {a: {type: mesh.judged, loss: none}}",
          "vars: {a: , b: }\nmatrix: {a: [1, x], b: {c: [2]}}\nstages: {s: {type: mesh.two}}", "preview: {a: {size: 1}}",
          "components: {codec: {type: codec.fast, level: 2}}\nstages: {s: {type: picture.write}}",
          "components: {codec: none}\nstages: {}", "components: {codec: '${c}'}\nstages: {}",
          "stages: {m: {type: texture.regions, regions: {floor: keep, '*': {texture: dark, strength: 0.5}}}}",
          // Over a base a stage may leave its type to the base, or be removed.
          "base: b.yaml\nstages: {a: {max_faces: 5}, b: }"})
    {
        CAPTURE(good);
        CHECK(check.accepts(yaml(good)));
    }
    for (const char* stage :
         {"{type: mesh.decimat}", "{max_faces: 5}", "{type: mesh.decimate, max_face: 5}", "{type: mesh.decimate, max_faces: 3}",
          "{type: mesh.decimate, max_faces: 1.5}", "{type: mesh.decimate, keep_borders: yes}",
          "{type: mesh.decimate, method: quick}", "{type: mesh.decimate, input: {meshes: b}}", "{type: mesh.two, input: b}",
          "{type: mesh.judged, needed: none}", "{type: uvmaps.raster,  heights_px: [1]}",
          "{type: uvmaps.raster,  input: {frames: {file: a.ply}}}",
          "{type: texture.optimize, losses: {a: {type: features.vgg, weights: w}}}",
          "{type: texture.optimize, losses: {a: {type: loss.gram, features: {type: features.vgg}}}}",
          "{type: texture.optimize, input: {style: {file: a, depth: 3}}}", "{type: picture.write, codec: codec.plain}",
          "{type: texture.regions, regions: {}}", "{type: texture.regions, regions: keep}",
          "{type: texture.regions, regions: {floor: {texture: dark, strength: 1.5}}}"})
    {
        CAPTURE(stage);
        CHECK_FALSE(check.accepts(yaml(std::string("stages: {a: ") + stage + "}")));
    }
    for (const char* bad :
         {"stage: {a: {type: mesh.two}}", "", "stages: {1a: {type: mesh.two}}", "stages: {}\npreview: {a: 1}",
          "base: b.yaml\nstages: {a: {type: mesh.decimate, max_faces: 1}}", "stages: {}\nmatrix: [a]",
          "stages: {}\nmatrix: {a: []}", "stages: {}\nmatrix: {1a: [1]}", "stages: {}\ncomponents: []",
          "stages: {}\ncomponents: {codec: loss.gram}", "stages: {}\ncomponents: {codec: {type: codec.fast, level: 0}}",
          "stages: {}\ncomponents: {loss: loss.gram}"})
    {
        CAPTURE(bad);
        CHECK_FALSE(check.accepts(yaml(bad)));
    }
    CHECK(fresco::to_json(check.schema().at("$defs").at("type.mesh.decimate").at("properties").at("max_faces")) ==
          R"json({"anyOf":[{"type":"integer","minimum":4,"maximum":50000000},{"$ref":"#/$defs/var"}],)json"
          R"json("description":"Stop at this many triangles (an integer from 4 to 50000000, count)","default":500000})json");
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
    struct Row
    {
        std::string rules, place, words;
    };
    for (const Row& row : std::vector<Row>{
             {"{flor: keep, walls: dark}", "8:93", "stage 'planes' (regions.planes) makes no 'flor' (did you mean 'floor'?)"},
             {"{floor: dusk, walls: dark}", "8:93", "option 'regions': 'input' has no texture 'dusk' (did you mean 'dark'?)"},
             {"{floor: keep, walls: keeep}", "8:106", "option 'regions': 'input' has no texture 'keeep' (did you mean 'keep'?)"},
             {"{floor: keep}", "8:69", "has no input 'dark' (there are: photo, regions)"},
             {"{floor: photo, walls: dark}", "8:93", "'photo' is another input of the stage"},
             {"{floor: {texture: dark, strength: 2}}", "8:126", "from 0 to 1 for 'strength' of 'floor', got 2"}})
    {
        CAPTURE(row.rules);
        CHECK_THAT(joined_lines(ruled("regions: planes, dark: night", row.rules)),
                   Catch::StartsWith("p.yaml:" + row.place + ": error: stage 'm' (texture.regions)") &&
                       Catch::Contains(row.words));
    }
    // Names that are only known when the stage has run.
    CHECK(joined_lines(ruled("regions: files, dark: night", "{flor: dark}")).empty());
    // For every combination.
    CHECK_THAT(joined_lines(ruled("regions: planes", "'${rules}'", "matrix: {rules: {a: {floor: keep}, b: {roof: keep}}}\n")),
               Catch::Contains("makes no 'roof'") && Catch::Contains("(with rules 'b')"));
}

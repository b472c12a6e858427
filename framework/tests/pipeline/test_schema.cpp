#include "catch.h"
#include "hand_made_catalog.h"
#include "schema_check.h"

#include "pipeline/schema.h"
#include "pipeline/yaml_document.h"

using namespace fresco::host;
using namespace fresco::host::testing;
using fresco::Value;

namespace
{
Value value_of(const YamlNode& node)
{
    if (node.is_scalar())
        return resolve_scalar(node).value;
    if (node.is_list())
    {
        Value::List list;
        for (const YamlNode& item : node.items)
            list.push_back(value_of(item));
        return list;
    }
    Value map = Value::Map{};
    if (node.is_map())
        for (const YamlNode::Entry& entry : node.entries)
            map.set(entry.key, value_of(entry.value));
    return node.is_map() ? map : Value();
}

Value yaml(const std::string& text)
{
    ProblemList problems;
    bool complete = false;
    const auto source = std::make_shared<const YamlSource>(YamlSource{"f", "/", false});
    const Value value = value_of(parse_yaml(text, source, problems, complete));
    REQUIRE(problems.empty());
    return value;
}
}  // namespace

TEST_CASE("The editor schema says what every type takes", "[schema]")
{
    const Value schema = pipeline_schema(hand_made_catalog());
    CHECK(schema.at("$schema").as_string() == "https://json-schema.org/draft/2020-12/schema");
    CHECK(schema.at("additionalProperties") == Value(false));
    const Value& decimate = schema.at("$defs").at("type.mesh.decimate");
    CHECK(decimate.at("additionalProperties") == Value(false));
    CHECK(decimate.at("description").as_string() == "What mesh.decimate does");
    const Value& faces = decimate.at("properties").at("max_faces");
    CHECK(fresco::to_json(faces) ==
          R"json({"anyOf":[{"type":"integer","minimum":4,"maximum":50000000},{"$ref":"#/$defs/var"}],)json"
          R"json("description":"Stop at this many triangles (an integer from 4 to 50000000, count)","default":500000})json");
    CHECK(fresco::to_json(decimate.at("properties").at("method").at("anyOf").as_list().at(0)) ==
          R"({"enum":["quadric","edge"]})");
    // The text is JSON that our own strict reader accepts.
    CHECK(fresco::parse_json(fresco::to_json(schema, 2)) == schema);
}

TEST_CASE("The editor schema accepts what the host accepts and refuses what it refuses", "[schema]")
{
    const Value schema = pipeline_schema(hand_made_catalog());
    const SchemaCheck check(schema);
    const auto stage = [&](const std::string& text) { return check.accepts(yaml("version: 1\nstages: {a: " + text + "}\n")); };

    CHECK(check.accepts(yaml(R"(version: 1
vars: {data: scan, n: 5}
stages:
  scan:    {type: scan.folder, path: "${data}"}
  mesh:    {type: mesh.decimate, input: scan, max_faces: "${n}"}
  uvmaps:  {type: uvmaps.raycast, input: {mesh: mesh, frames: scan.frames}, heights_px: [256, "${n}"]}
  texture:
    type: texture.optimize
    input: {maps: uvmaps, frames: scan, style: {file: pic.jpg, max_px: 9}}
    losses: {style: {type: loss.gram, weight: 1e-4, features: {type: features.vgg, weights: w}}, c: loss.content}
)")));
    CHECK(stage("{type: mesh.decimate, input: {file: a.ply}}"));
    CHECK(stage("{type: texture.optimize, losses: auto}"));
    CHECK(stage("{type: mesh.judged, loss: none}"));

    CHECK_FALSE(stage("{type: mesh.decimat}"));
    CHECK_FALSE(stage("{max_faces: 5}"));
    CHECK_FALSE(stage("{type: mesh.decimate, max_face: 5}"));
    CHECK_FALSE(stage("{type: mesh.decimate, max_faces: 3}"));
    CHECK_FALSE(stage("{type: mesh.decimate, max_faces: 1.5}"));
    CHECK_FALSE(stage("{type: mesh.decimate, max_faces: many}"));
    CHECK_FALSE(stage("{type: mesh.decimate, keep_borders: yes}"));
    CHECK_FALSE(stage("{type: mesh.decimate, method: quick}"));
    CHECK_FALSE(stage("{type: mesh.decimate, input: {meshes: b}}"));
    CHECK_FALSE(stage("{type: mesh.two, input: b}"));
    CHECK_FALSE(stage("{type: mesh.judged, needed: none}"));
    CHECK_FALSE(stage("{type: uvmaps.raycast, heights_px: [1]}"));
    CHECK_FALSE(stage("{type: uvmaps.raycast, input: {frames: {file: a.ply}}}"));
    CHECK_FALSE(stage("{type: texture.optimize, losses: {a: {type: features.vgg, weights: w}}}"));
    CHECK_FALSE(stage("{type: texture.optimize, losses: {a: {type: loss.gram, wait: 1}}}"));
    CHECK_FALSE(stage("{type: texture.optimize, losses: {a: {type: loss.gram, features: {type: features.vgg}}}}"));
    CHECK_FALSE(stage("{type: texture.optimize, input: {style: {file: a, depth: 3}}}"));
    CHECK_FALSE(check.accepts(yaml("version: 2\nstages: {a: {type: mesh.two}}\n")));
    CHECK_FALSE(check.accepts(yaml("version: 1\nstage: {a: {type: mesh.two}}\n")));
    CHECK_FALSE(check.accepts(yaml("version: 1\n")));
    CHECK_FALSE(check.accepts(yaml("version: 1\nstages: {1a: {type: mesh.two}}\n")));

    CHECK(check.accepts(yaml("version: 1\nvars: {a: , b: }\nmatrix: {a: [1, x], b: {c: [2]}}\nstages: {s: {type: mesh.two}}\n")));
    for (const char* matrix : {"[a]", "{a: []}", "{a: {}}", "{a: 1}", "{a: [1, 1]}", "{1a: [1]}"})
        CHECK_FALSE(check.accepts(yaml(std::string("version: 1\nmatrix: ") + matrix + "\nstages: {s: {type: mesh.two}}\n")));

    CHECK(check.accepts(yaml("version: 1\nstages: {a: {type: mesh.two}}\npreview: {a: {size: 1}}\n")));
    CHECK_FALSE(check.accepts(yaml("version: 1\nstages: {a: {type: mesh.two}}\npreview: {a: 1}\n")));
    CHECK(check.accepts(yaml("version: 1\npreview: {a: {size: 1}}\n")));
    // Over a base a stage may leave its type to the base, or be removed.
    CHECK(check.accepts(yaml("version: 1\nbase: b.yaml\nstages: {a: {max_faces: 5}, b: }\n")));
    CHECK_FALSE(check.accepts(yaml("version: 1\nbase: b.yaml\nstages: {a: {type: mesh.decimate, max_faces: 1}}\n")));
}

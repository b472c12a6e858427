#include "catch.h"
#include "hand_made_catalog.h"

#include "base/text.h"
#include "pipeline/pipeline.h"
#include "run/commands_inspect.h"

#include <sstream>

using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{
Catalog small_catalog()
{
    Catalog catalog;
    catalog.add(described("mesh.pass", "stage", R"({
        "options": [{"name": "size_px", "kind": "int", "default": 5, "min": 1.0, "help": "A size"},
                    {"name": "path", "kind": "input_file", "required": true, "help": "A file"},
                    {"name": "note", "kind": "text", "default": "", "in_key": false, "help": "A note"},
                    {"name": "style", "kind": "component", "component_kind": "loss", "help": "A loss"}],
        "components": [{"name": "codec", "kind": "component", "component_kind": "codec", "default": {"type": "codec.plain"},
                        "help": "Encodes"}],
        "inputs": [{"name": "mesh", "artifact": "mesh", "version": 1, "optional": true, "help": "What comes in"}],
        "outputs": [{"name": "out", "artifact": "mesh", "version": 3, "help": "What goes out"}]})"));
    catalog.add(described("loss.gram", "loss", "{}"));
    catalog.add(described("loss.twice", "loss", "{}"));
    catalog.add(described("loss.twice", "loss", "{}"));
    catalog.add(Refusal{"/plugins/mesh_old.so", "SDK ABI 0, this program has 1"});
    catalog.add(UnbuiltPlugin{"mesh.rays", "Embree was not found"});
    catalog.add(UnbuiltPlugin{"mesh.later", ""});
    return catalog;
}
}  // namespace

TEST_CASE("stages lists what there is, and with --all what cannot be used", "[inspect]")
{
    const Catalog catalog = small_catalog();
    const auto listed = [&](const Catalog& of, bool all, bool json)
    {
        std::ostringstream out;
        CHECK(write_stages(of, all, json, without_end, out) == 0);
        return out.str();
    };
    CHECK(listed(catalog, false, false) == "  mesh.pass  stage  What mesh.pass does\n"
                                           "  loss.gram  loss   What loss.gram does\n"
                                           "\n2 plugins or types cannot be used: see 'fresco stages --all'\n");
    CHECK_THAT(listed(catalog, true, false),
               Contains("[/plugins/mesh.pass.so]") &&
                   Contains("\n  not used, because several plugins have it: loss.twice: /plugins/loss.twice.so and") &&
                   Contains("\n  refused: /plugins/mesh_old.so: SDK ABI 0") &&
                   Contains("\n  not built: mesh.rays: Embree was not found\n  not built: mesh.later\n"));
    const fresco::Value value = fresco::parse_json(listed(catalog, true, true));
    CHECK(value.at("types").as_list().at(1).at("type").as_string() == "mesh.pass");
    CHECK(value.at("ambiguous").as_list().at(0).at("libraries").as_list().size() == 2);
    CHECK(value.at("unbuilt").as_list().at(0).at("reason").as_string() == "Embree was not found");
    CHECK_THAT(listed({}, false, false), Contains("no plugin was found"));
}

TEST_CASE("describe prints ports, options, defaults and ranges", "[inspect]")
{
    const Catalog catalog = small_catalog();
    std::ostringstream out;
    std::ostringstream json;
    std::ostringstream errors;
    CHECK(write_description(catalog, "mesh.pass", false, without_end, out, errors) == 0);
    CHECK(out.str() == R"(mesh.pass (stage): What mesh.pass does
in /plugins/mesh.pass.so

inputs:
  mesh  mesh, optional  What comes in

outputs:
  out  mesh (version 3)  What goes out

options (name, default, accepted, what it is):
  size_px  5         an integer of at least 1           A size
  path     required  the path of an existing file       A file
  note     ""        text                               A note (cannot change the result)
  style    none      {type: …} of kind 'loss', or none  A loss

for 'style' there is: loss.gram

components that the pipeline chooses (kind, default, what it is):
  codec  codec.plain  Encodes
)");
    CHECK(write_description(catalog, "mesh.pass", true, without_end, json, errors) == 0);
    CHECK(fresco::parse_json(json.str()).at("declaration") == catalog.find("mesh.pass")->declaration);
    CHECK(errors.str().empty());
    CHECK(write_description(catalog, "los.gram", false, without_end, out, errors) == 2);
    CHECK_THAT(errors.str(), Contains("unknown type 'los.gram' (did you mean 'loss.gram'?)"));
    CHECK(write_description(catalog, "loss.twice", false, without_end, out, errors) == 4);
    CHECK(write_description(catalog, "mesh.old", false, without_end, out, errors) == 4);
    CHECK_THAT(errors.str(), Contains("SDK ABI 0"));
}

TEST_CASE("check prints problems, as lines and as JSON", "[inspect]")
{
    const TemporaryFolder folder;
    const PipelineResult bad =
        check(folder, "version: 1\nstages:\n  a: {type: mesh.two, x: 1}\n  b: {type: mesh.pass, input: {file: no.ply}}\n");
    const auto checked = [](const PipelineResult& result, bool json)
    {
        std::ostringstream text;
        CHECK(write_check(result, json, text) == result.exit_code());
        return text.str();
    };
    CHECK(bad.exit_code() == 2);
    CHECK_THAT(checked(bad, false), Catch::StartsWith("p.yaml:3:23: error: stage 'a' (mesh.two) has no option 'x'") &&
                                        Contains("\np.yaml:4:38: error:"));
    const fresco::Value value = fresco::parse_json(checked(bad, true));
    CHECK(value.at("ok") == fresco::Value(false));
    CHECK(value.at("problems").as_list().at(1).at("kind").as_string() == "missing_input");
    CHECK(value.at("problems").as_list().at(1).at("column") == fresco::Value(38));
    CHECK(checked(check(folder, "version: 1\nstages:\n  a: {type: mesh.two}\n"), false) ==
          (folder.path() / "p.yaml").string() + ": 1 stage, no problems\n");
}

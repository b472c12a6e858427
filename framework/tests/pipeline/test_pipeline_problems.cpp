#include "catch.h"
#include "comma_locale.h"
#include "hand_made_catalog.h"

#include "pipeline/yaml_document.h"

#include <fmt/format.h>

using namespace fresco::host;
using namespace fresco::host::testing;

namespace
{
/// The problems of stages, from line 3 of the file on.
std::string problem_of(const std::string& stages)
{
    return joined_lines(check({}, "version: 1\nstages:\n  " + stages + "\n"));
}
}  // namespace

TEST_CASE("Every problem is reported at once, in the file's order, with its place and what is right", "[pipeline]")
{
    const PipelineResult result = check({}, R"(version: 2
var: {}
vars: {mesh: 1, a: "${b}", b: "${a}"}
stages:
  scan:    {type: scan.foldr, path: "${data}"}
  frames:  {type: frames.sharpest, input: scann, min_sharpnes: 150}
  mesh:    {type: mesh.decimate,   input: uvmaps, max_faces: 3, keep_borders: on, method: quadrik, method: x}
  uvmaps:  {type: uvmaps.raster,   input: {mesh: &x frames.kep, frams: frames}, heights_px: 256, weights: [1, 010, .nan, x]}
  texture:
    type: texture.optimize
    input: {maps: uvmaps, frames: frames, style: {file: "${a}.tga"}}
    losses: {style: loss.gran, b: {type: loss.gram, features: {type: loss.gram}}}
  p: {type: mesh.pass, input: p, title: 42, size:}
  q:
  1r: {type: mesh.pass}
  two: {type: mesh.two, input: p}
  t: {type: mesh.pass, input: two}
  f: {type: mesh.future, input: {mesh: two.right}}
  g: {type: mesh.decimate}
  h: {type: scan.folder}
)");
    CHECK(result.pipeline.stages.empty());
    CHECK(result.exit_code() == 2);
    const std::vector<std::pair<std::string, std::string>> expected{
        {"1:10", "version must be 1, got 2"},
        {"2:1", "unknown key 'var' (did you mean 'vars'?)"},
        {"3:8", "the var 'mesh' has the name of the stage on line 7"},
        {"3:31", "cycle of vars: a → b → a"},
        {"5:19", "stage 'scan': unknown type 'scan.foldr' (did you mean 'scan.folder'?)"},
        {"5:37", "unknown var 'data' (there are: a, b, mesh)"},
        {"6:43", "stage 'frames' (frames.sharpest): unknown stage 'scann' (did you mean 'scan'?)"},
        {"6:50", "has no option 'min_sharpnes' (did you mean 'min_sharpness'?)"},
        {"7:43", "stage 'mesh' (mesh.decimate): 'uvmaps' is maps (uv_maps); expected mesh (mesh)"},
        {"7:62", "3 is too small; expected an integer from 4 to 50000000"},
        {"7:79", "expected true or false, got the text 'on'"},
        {"7:91", "'quadrik' is not known (did you mean 'quadric'?); expected one of quadric, edge"},
        {"7:100", "the key 'method' appears twice; the first is on line 7"},
        {"8:50", "anchors (&x)"},
        {"8:50", "stage 'frames' (frames.sharpest) has no output 'kep' (did you mean 'kept'?)"},
        {"8:65", "has no input 'frams' (did you mean 'frames'?)"},
        {"8:93", "each entry an integer from 16 to 4096, got 256"},
        {"8:111", "'010' begins with 0"},
        {"8:116", "'.nan' is not a finite number"},
        {"8:122", "each entry a number, got the text 'x'"},
        {"12:21", "option 'losses.style': unknown type 'loss.gran' (did you mean 'loss.gram'?)"},
        {"12:70", "option 'losses.b' (loss.gram): option 'features': 'loss.gram' is of kind 'loss'; expected kind 'features'"},
        {"13:31", "cycle: p → p"},
        {"13:41", "expected text, got 42"},
        {"13:45", "option 'size' has no value"},
        {"14:3", "stage 'q' must be a map {type: …, option: …}, got nothing"},
        {"15:3", "'1r' cannot name a stage"},
        {"16:25", "stage 'two' (mesh.two) takes no input"},
        {"17:31", "'two' is ambiguous: name the ports, such as {mesh: two.left}"},
        {"18:40", "'two.right' is right (mesh); expected mesh (mesh (version 2))"},
        {"19:3", "needs the input 'mesh' (mesh); it is made by mesh.simplified, p.mesh, 1r.mesh, two.left, two.right and t.mesh"},
        {"20:3", "needs the option 'path': the path of an existing folder (Folder of the scan)"}};
    const Words found = lines(result);
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
        CHECK_THAT(found[i], StartsWith("p.yaml:" + expected[i].first + ": error: ") && Contains(expected[i].second));
}

TEST_CASE("A value or an input that does not fit is named with what is accepted", "[pipeline]")
{
    for (const auto& [stages, problem] : std::vector<std::pair<std::string, std::string>>{
             {"a: {type: mesh.pass, size: '5'}",
              "3:30: error: stage 'a' (mesh.pass): option 'size': expected a number, got the text '5'"},
             {"a: {type: export.gltf, path: ../x.glb}", "'../x.glb' is not accepted; expected a relative path below --out"},
             {"a: {type: uvmaps.raster, heights_px: [16, 4096, 4097]}",
              "3:51: error: stage 'a' (uvmaps.raster): option 'heights_px': 4097 is too large"},
             {"a: {title: x}", "3:3: error: stage 'a': missing 'type'"},
             {"a: {type: 5}", "expected a type such as 'mesh.decimate', got 5"},
             {"a: {type: mesh.pass, title: \"${x\"}", "a '${' is not closed"},
             {"a: {type: mesh.pass, input: [b]}", "must be a stage's name, {port: stage, …} or {file: PATH}, got a list"},
             {"a: {type: mesh.pass, input: }", "3:24: error: stage 'a' (mesh.pass): 'input' has no value"},
             {"a: {type: mesh.pass, input: room.ply}", "a file is written {file: room.ply}"},
             {"a: {type: mesh.pass, input: {mesh: {fil: x}}}", "must be a stage's name or {file: PATH}, got a map"},
             {"a: {type: mesh.pass, input: {file: x.ply}}", "3:38: error: stage 'a' (mesh.pass): input 'mesh': no such file '"},
             {"a: {type: mesh.pass, input: {file: x.ply, type: read.image}}", "'read.image' makes no mesh"},
             {"a: {type: mesh.pass, input: {file: x.ply, depth: 1}}", "has no option 'depth'"},
             {"a: {type: mesh.decimate, input: {file: ''}}",
              "needs the input 'mesh' (mesh); no other stage of this pipeline makes mesh before it"},
             {"a: {type: mesh.decimate}\n  b: {type: mesh.pass, input: a}\n  c: {type: mesh.pass, input: b}\n  d: {type: "
              "mesh.two}",
              "needs the input 'mesh' (mesh); it is made by d.left and d.right"}})
        CHECK_THAT(problem_of(stages), Contains(problem));
}

TEST_CASE("A component that the pipeline chooses is checked once, used or not", "[pipeline]")
{
    const Catalog catalog = catalog_with_codecs();
    for (const auto& [components, problem] : std::vector<std::pair<std::string, std::string>>{
             {"{codec: none}", "21: error: stage 'a' (picture.write) needs a component of kind 'codec' (Encodes): set one by its "
                               "type | p.yaml:2:21: error: stage 'b'"},
             {"{codec: codec.plane}", "21: error: components: 'codec': unknown type 'codec.plane' (did you mean 'codec.plain'?)"},
             {"{codec: loss.gram}", "21: error: components: 'codec': 'loss.gram' is of kind 'loss'"},
             {"{codec: {type: codec.fast, level: 0}}", "47: error: components: 'codec' (codec.fast): option 'level': 0 is too "},
             {"{codek: codec.fast}", "14: error: no stage takes components of the kind 'codek' from the pipeline (did you mean"},
             {"{loss: loss.gram}", "14: error: no stage takes components of the kind 'loss'"},
             {"{codec: }", "14: error: components: 'codec' has no value"},
             {"[codec.fast]", "13: error: 'components' must be a map {name: …}, got a list"},
             {"{codec: '${c}'}", "21: error: unknown var 'c'"}})
        CHECK_THAT(
            joined_lines(check(
                {}, "version: 1\ncomponents: " + components + "\nstages: {a: {type: picture.write}, b: {type: picture.write}}\n",
                catalog)),
            StartsWith("p.yaml:2:" + problem));
    const std::string stage = "version: 1\nstages: {components: {type: picture.write}}\n";
    CHECK(joined_lines(check({}, stage, catalog)) ==
          "p.yaml:2:10: error: 'components' cannot name a stage: --set components.KIND=… sets the pipeline's components");
    const std::string unused = "version: 1\ncomponents: {codec: codec.lost}\nstages: {b: {type: mesh.two}}\n";
    CHECK(check({}, unused, catalog).exit_code() == 2);
}

TEST_CASE("Two stages do not write one file", "[pipeline]")
{
    const auto writing = [](const std::string& preview, const std::string& one, const std::string& other)
    {
        return problem_of("t: {type: texture.optimize, preview: " + preview + "}\n  a: {type: export.gltf, input: t, path: " +
                          one + "}\n  b: {type: export.gltf, input: t, path: " + other + "}");
    };
    CHECK_THAT(writing("room.glb", "room.glb", "x/../room.glb"),
               Contains("error: the stages t and a would both write room.glb") && Contains("'x/../room.glb' is not accepted"));
    CHECK_THAT(writing("a", "a/b.glb", "a/b.glb/c.glb"),
               Contains("p.yaml:5:42: error: the stage a would write the file a/b.glb below --out, and the stage b would") &&
                   !Contains("stage t would"));  // Several may write into one folder.
}

TEST_CASE("What is missing, and which plugin fails, leads to its own exit code", "[pipeline]")
{
    const TemporaryFolder folder;
    folder.write("file.txt", "");
    folder.write("folder.ply/a", "");
    Catalog catalog = hand_made_catalog();
    catalog.add(described("mesh.twice", "stage", R"({"options": []})"));
    TypeDescription other = described("mesh.twice", "stage", R"({"options": []})");
    other.library = "/elsewhere/mesh_twice.so";
    catalog.add(other);
    catalog.add(Refusal{"/plugins/mesh_broken.so", "SDK ABI 2, this program has 1"});
    catalog.add(described("mesh.odd", "stage", R"({"options": [{"name": "x", "kind": "color"}]})"));
    catalog.add(UnbuiltPlugin{"texture.heavy", "libtorch was not found"});
    for (const auto& [stages, exit_code, words] : std::vector<std::tuple<std::string, int, std::string>>{
             {"a: {type: scan.folder, path: nowhere}", 3, "no such folder '" + (folder.path() / "nowhere").string() + "'"},
             {"a: {type: scan.folder, path: \"${data}\"}", 3,
              "p.yaml:3:39: error: the var 'data' has no value: set it with --set"},
             {"a: {type: scan.folder, path: file.txt}", 3, "is not a folder"},
             {"a: {type: scan.folder, path: nowhere}, b: {type: mesh.twice}", 4,
              "/plugins/mesh.twice.so and /elsewhere/mesh_twice.so"},
             {"a: {type: mesh.broken}", 4, "is probably in /plugins/mesh_broken.so, which cannot be used: SDK ABI 2"},
             {"a: {type: mesh.odd}", 4, ""},
             {"a: {type: texture.heavy}", 4, "not built (libtorch was not found): run ./bootstrap build"},
             {"a: {type: mesh.broken}, b: {type: nothing}", 2, ""}})
    {
        CAPTURE(stages);
        const PipelineResult result = check(folder, "version: 1\nvars: {data: }\nstages: {" + stages + "}\n", catalog);
        CHECK_THAT(joined_lines(result), Contains(words));
        CHECK(result.exit_code() == exit_code);
    }
}

TEST_CASE("A file that is not a pipeline is one clear problem, as is a bad var, used or not", "[pipeline]")
{
    for (const auto& [text, problem] : std::vector<std::pair<std::string, std::string>>{
             {"", "p.yaml:1:1: error: the file is empty"},
             {"- 1\n", "p.yaml:1:1: error: a pipeline is a map"},
             {"version: 1\n", "p.yaml:1:1: error: missing stages"},
             {"version: 1\nstages:\n", "p.yaml:1:1: error: missing stages"},
             {"version: 1\nstages: []\n", "p.yaml:2:9: error: 'stages' must be a map"},
             {"stages: {a: {type: mesh.two}}\n", "p.yaml:1:1: error: missing 'version: 1'"},
             {"version: 1\nstages: {a: {type: mesh.two}}\n---\n", "p.yaml:3:1: error: a second document"},
             {"version: 1\nvars: {b: '${nope}'}\nstages: {s: {type: mesh.two}}\n", "p.yaml:2:11: error: unknown var 'nope'"},
             {"version: 1\nvars: {c: '${d}', d: '${c}'}\nstages: {s: {type: mesh.two}}\n",
              "p.yaml:2:22: error: cycle of vars: c → d → c"},
             {std::string(yaml_size_limit + 1, '#'), "p.yaml: error: "}})
        CHECK_THAT(joined_lines(check({}, text)), StartsWith(problem) && !Contains(" | "));
    const TemporaryFolder folder;
    const PipelineResult missing = load_pipeline({"none.yaml", {}, folder.path()}, usual_catalog());
    CHECK_THAT(joined_lines(missing),
               StartsWith("none.yaml: error: " + (folder.path() / "none.yaml").string() + ": cannot be opened"));
    CHECK(missing.exit_code() == 3);
    CHECK_THAT(joined_lines(load_pipeline({folder.path(), {}, {}}, usual_catalog())), Contains("is not a regular file"));
}

TEST_CASE("A cycle of 1 000 stages is one short problem", "[pipeline]")
{
    std::string text = "version: 1\nstages:\n";
    for (int i = 0; i < 1000; ++i)
        text += fmt::format("  s{}: {{type: mesh.pass, input: s{}}}\n", i, (i + 999) % 1000);
    CHECK(lines(check({}, text)) ==
          Words{"p.yaml:3:32: error: cycle: s0 → s1 → s2 → s3 → s4 → s5 → s6 → s7 → … (1000 stages) → s0"});
}

TEST_CASE("Only the first mistakes of a file get hints: hints for all take minutes", "[pipeline]")
{
    std::string text = "version: 1\nvars:\n";
    std::string list = "stages:\n  list:\n    type: mesh.pass\n";
    for (int i = 0; i < 1000; ++i)
    {
        text += fmt::format("  var_{:05}: 1\n", i);
        list += fmt::format("    o{}: \"${{vor_{:05}}}\"\n", i, i);
    }
    const std::string told = joined_lines(check({}, text + list));
    CHECK_THAT(told, Contains("unknown var 'vor_00000' (did you mean 'var_00000'?)") && Contains("unknown var 'vor_00999'") &&
                         !Contains("unknown var 'vor_00999' (did"));
}

TEST_CASE("Many problems of one place are told by the first of them; other problems are not lost among them", "[pipeline]")
{
    std::vector<Problem> problems(3000, {{"p.yaml", 3, 18}, "a bad value"});
    problems.push_back({{"p.yaml", 5, 43}, "another"});
    const Words told_lines = told(problems);
    REQUIRE(told_lines.size() == 12);
    CHECK(told_lines[10] == "p.yaml:5:43: error: another");
    CHECK(told_lines[11] == "… and 2990 more like this: p.yaml:3:18: error: a bad value");
}

TEST_CASE("Vars that grow without bound are refused", "[pipeline]")
{
    std::string text = "version: 1\nvars:\n  v0: xxxxxxxxxxxxxxxx\n";
    std::string lists = "version: 1\nvars:\n  v0: [x]\n";
    for (int i = 1; i < 30; ++i)
        text += fmt::format("  v{0}: \"${{v{1}}}${{v{1}}}${{v{1}}}\"\n", i, i - 1);
    for (int i = 1; i < 40; ++i)
        lists += fmt::format("  v{}: [\"${{v{}}}\"]\n", i, i - 1);
    const auto problems = [](const std::string& vars, const std::string& last)
    { return joined_lines(check({}, vars + "stages: {a: {type: mesh.pass, title: \"${" + last + "}\"}}\n")); };
    CHECK_THAT(problems(text, "v29"), Contains("the vars grow to more than 4 MiB"));
    CHECK_FALSE(problems(lists, "v39").empty());
}

TEST_CASE("Numbers are read alike where a comma is the decimal point", "[pipeline]")
{
    const CommaLocale comma("numbers of pipelines");
    CHECK(options_of(check({}, "version: 1\nstages: {a: {type: mesh.pass, size: 1.5}}\n"), "a") == R"({"title":"","size":1.5})");
    CHECK_FALSE(problem_of("a: {type: mesh.pass, size: 1,5}").empty());
}

TEST_CASE("Only the words of a program have several lines; control characters are nowhere", "[pipeline]")
{
    for (const std::string text : {"\"a\\nb\"", "\"a\\tb\"", "|\n      a\n"})
        CHECK_THAT(problem_of("a:\n    type: mesh.pass\n    title: " + text),
                   StartsWith("p.yaml:5:12: error: stage 'a' (mesh.pass): option 'title': ") &&
                       Contains("an end of line or a tab"));
    for (const auto& [name, value, problem] :
         std::vector<std::array<std::string, 3>>{{"a.title", "y\x1b", "it has a control character"},
                                                 {"a.ti\x01tle", "y", "it has a control character"},
                                                 {"a.title", R"("y\0")", "control character"},
                                                 {"a.title", "y\nz", "an end of line or a tab"}})
        CHECK_THAT(joined_lines(check({}, "version: 1\nstages:\n  a: {type: mesh.pass}\n", usual_catalog(), {{name, value}})),
                   StartsWith("--set ") && Contains(problem));
}

TEST_CASE("A stage is left out by --without, which none that stays may read", "[pipeline]")
{
    const Room folder;
    folder.write("p.yaml", room);
    const auto load = [&](Words without, Sets sets = {}, const std::string& until = "")
    {
        return load_pipeline({.file = "p.yaml",
                              .sets = std::move(sets),
                              .working_directory = folder.path(),
                              .until = until,
                              .without = std::move(without)},
                             usual_catalog());
    };
    CHECK(names_of(load({"glb", "texture", "glb"})) == Words{"scan", "frames", "mesh", "uvmaps"});
    CHECK(joined_lines(load({"mesh"})) ==
          "--without mesh: error: stage 'uvmaps' (uvmaps.raster) reads it: leave that out, too (--without uvmaps), or set "
          "its input");
    CHECK(names_of(load({"mesh"}, {{"uvmaps.input.mesh", "scan"}})) == Words{"scan", "frames", "uvmaps", "texture", "glb"});
    CHECK(joined_lines(load({"gbl"})) == "--without gbl: error: unknown stage 'gbl' (did you mean 'glb'?)");
    CHECK_THAT(joined_lines(load({"glb"}, {}, "glb")), StartsWith("--until glb: error: unknown stage 'glb'"));
}

TEST_CASE("A result that nobody reads is worth a warning in a pipeline that writes files", "[pipeline]")
{
    const Room folder;
    const auto warnings = [&](const std::string& text, const std::string& until = "")
    {
        folder.write("p.yaml", text);
        const PipelineResult result =
            load_pipeline({.file = "p.yaml", .sets = {}, .working_directory = folder.path(), .until = until}, usual_catalog());
        CHECK(joined_lines(result).empty());
        return each(result.warnings, [](const Problem& problem) { return to_string(problem); });
    };
    const std::string more = "  mixed: {type: mesh.pass, input: mesh}\n";
    CHECK(warnings(room + more) ==
          Words{"p.yaml:13:3: warning: no stage reads the result of 'mixed': name it as the input of one, or "
                "leave it out (--without mixed)"});
    CHECK(warnings(room + more, "mixed").empty());
    // Once for all combinations.
    CHECK(warnings(room + "  mixed: {type: mesh.pass, title: \"${weights}\"}\nmatrix: {weights: [vgg.st, pic.jpg]}\n").size() ==
          1);
}

TEST_CASE(
    "A misspelled variable is found in every value of an axis, used or not; what --set means to an unknown type is not told")
{
    CHECK_THAT(joined_lines(
                   check({}, "version: 1\nvars: {style: }\nmatrix: {style: [a, \"${typo}\"]}\nstages:\n  a: {type: mesh.pass}\n",
                         usual_catalog())),
               Contains("typo"));
    const auto told = joined_lines(
        check({}, "version: 1\nstages:\n  a: {type: no.such, part: some.part}\n", usual_catalog(), {{"a.part.size", "2"}}));
    CHECK_THAT(told, Contains("no.such") && !Contains("set it as a whole"));
}

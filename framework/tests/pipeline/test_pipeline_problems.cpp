#include "catch.h"
#include "hand_made_catalog.h"
#include "shared_data.h"

#include "pipeline/yaml_document.h"

#include <clocale>
#include <fmt/format.h>
#include <locale>

using namespace fresco::host;
using namespace fresco::host::testing;
using Catch::Contains;
using Catch::StartsWith;

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
        {"7:43", "input 'mesh' takes mesh, but stage 'uvmaps' (uvmaps.raster) makes maps (uv_maps)"},
        {"7:62", "3 is too small; expected an integer from 4 to 50000000"},
        {"7:79", "expected true or false, got the text 'on' (write true)"},
        {"7:91", "'quadrik' is not known (did you mean 'quadric'?); expected one of quadric, edge"},
        {"7:100", "the key 'method' appears twice; the first is on line 7"},
        {"8:50", "anchors (&x)"},
        {"8:50", "stage 'frames' (frames.sharpest) has no output 'kep' (did you mean 'kept'?)"},
        {"8:65", "has no input 'frams' (did you mean 'frames'?)"},
        {"8:93", "each entry an integer from 16 to 4096, got 256 (write [256])"},
        {"8:111", "'010' begins with 0"},
        {"8:116", "'.nan' is not a finite number"},
        {"8:122", "each entry a number, got the text 'x'"},
        {"12:21", "option 'losses.style': unknown type 'loss.gran' (did you mean 'loss.gram'?)"},
        {"12:70", "option 'losses.b' (loss.gram): option 'features': 'loss.gram' is of kind 'loss'; expected kind 'features'"},
        {"13:31", "cycle: p → p"},
        {"13:41", "expected text, got 42 (write '42' in quotes)"},
        {"13:45", "option 'size' has no value"},
        {"14:3", "stage 'q' must be a map {type: …, option: …}, got nothing"},
        {"15:3", "'1r' cannot name a stage"},
        {"16:25", "stage 'two' (mesh.two) takes no input"},
        {"17:31", "'two' is ambiguous: name the port: {mesh: two.left} or {mesh: two.right}"},
        {"18:40", "input 'mesh' takes mesh (version 2), but output 'right' of stage 'two' (mesh.two) is mesh"},
        {"19:3", "needs the input 'mesh' (mesh); it is made by mesh.simplified, p.mesh, 1r.mesh, two.left, two.right and t.mesh"},
        {"20:3", "needs the option 'path': the path of an existing folder (Folder of the scan)"}};
    const Words found = lines(result);
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
        CHECK_THAT(found[i], StartsWith("p.yaml:" + expected[i].first + ": error: ") && Contains(expected[i].second));
}

TEST_CASE("A value or an input that does not fit is named with what is accepted and what was probably meant", "[pipeline]")
{
    const auto height = [](const std::string& text)
    { return "a: {type: uvmaps.raster,  input: b, heights_px: [" + text + "]}\n  b: {type: nothing}"; };
    const auto decimated = [](const std::string& option)
    { return "m: {type: mesh.two}\n  d: {type: mesh.decimate, input: m.left, " + option + "}"; };
    for (const auto& [stages, problem] : std::vector<std::pair<std::string, std::string>>{
             {"a: {type: mesh.pass, size: '5'}",
              "3:30: error: stage 'a' (mesh.pass): option 'size': expected a number, got the text '5' (without the quotes)"},
             {"a: {type: mesh.pass, size: \"0,5\"}", "(write 0.5)"},
             {"a: {type: mesh.pass, size: [1]}", "expected a number, got a list"},
             {"a: {type: mesh.pass, title: true}", "expected text, got true (write 'true' in quotes)"},
             {"a: {type: mesh.pass, size: .inf}", "'.inf' is not a finite number"},
             {"a: {type: mesh.two, x: 1}", "has no option 'x': it has none"},
             {decimated("max_faces: 1e6"), "(write 1000000)"},
             {decimated("keep_borders: 1"), "(write true)"},
             {"a: {type: export.gltf, path: ../x.glb}", "'../x.glb' is not accepted; expected a relative path below --out"},
             {"a: {type: export.gltf, path: /x.glb}", "'/x.glb' is not accepted"},
             {height("4097"), "4097 is too large; expected a list, each entry an integer from 16 to 4096"},
             {height("15"), "15 is too small"},
             {"a: {title: x}", "3:3: error: stage 'a': missing 'type'"},
             {"a: {typ: mesh.pass}", "missing 'type' (is 'typ' meant to be it?)"},
             {"a: {type: 5}", "expected a type such as 'mesh.decimate', got 5"},
             {"a: [1]", "stage 'a' must be a map"},
             {"a: {type: loss.gram}", "'loss.gram' is of kind 'loss'; expected kind 'stage'"},
             {"a: {type: mesh.pass, title: \"${x\"}", "a '${' is not closed"},
             {"s: {type: scan.folder, path: .}\n  u: {type: uvmaps.raster,  input: s.mesh}",
              "needs the input 'frames' (frames); it is made by s.frames"},
             // Stages that would close a cycle are not suggested.
             {"a: {type: mesh.decimate}\n  b: {type: mesh.pass, input: a}\n  c: {type: mesh.pass, input: b}",
              "no stage of this pipeline makes mesh"},
             {"a: {type: mesh.pass, input: [b]}", "must be a stage's name, {port: stage, …} or {file: PATH}, got a list"},
             {"a: {type: mesh.pass, input: }", "3:24: error: stage 'a' (mesh.pass): 'input' has no value"},
             {"a: {type: mesh.pass, input: room.ply}", "a file is written {file: room.ply}"},
             {"a: {type: mesh.pass, input: {mesh: {fil: x}}}", "must be a stage's name or {file: PATH}, got a map"},
             {"a: {type: mesh.pass, input: {file: x.ply}}", "3:38: error: stage 'a' (mesh.pass): input 'mesh': no such file '"},
             {"a: {type: mesh.pass, input: {file: x.ply, type: read.image}}", "'read.image' makes no mesh"},
             {"a: {type: mesh.pass, input: {file: x.ply, depth: 1}}", "has no option 'depth'"},
             {"a: {type: mesh.decimate, input: {file: ''}}",
              "needs the input 'mesh' (mesh); no stage of this pipeline makes mesh"},
             {"a: {type: uvmaps.raster,  input: a}",
              "takes mesh (mesh) and frames (frames), but stage 'a' (uvmaps.raster) makes maps (uv_maps)"}})
        CHECK_THAT(problem_of(stages), Contains(problem));
    CHECK_THAT(problem_of(height("16, 4096")), !Contains("heights_px"));
}

TEST_CASE("A component that the pipeline chooses is checked once, used or not", "[pipeline]")
{
    const TemporaryFolder folder;
    const Catalog catalog = catalog_with_codecs();
    const auto found = [&](const std::string& components, const std::string& more = "", const Sets& sets = {})
    {
        return joined_lines(check(folder,
                                  "version: 1\ncomponents: " + components +
                                      "\nstages: {a: {type: picture.write}, b: {type: picture.write}" + more + "}\n",
                                  catalog, sets));
    };
    CHECK(found("{codec: none}")
              .starts_with("p.yaml:2:21: error: stage 'a' (picture.write) needs a component of kind 'codec' "
                           "(Encodes): set one by its type | p.yaml:2:21: error: stage 'b'"));
    CHECK(found("{codec: codec.plane}") ==
          "p.yaml:2:21: error: components: 'codec': unknown type 'codec.plane' (did you mean 'codec.plain'?)");
    CHECK(found("{codec: loss.gram}").starts_with("p.yaml:2:21: error: components: 'codec': 'loss.gram' is of kind 'loss'"));
    CHECK(found("{codec: {type: codec.fast, level: 0}}") == "p.yaml:2:47: error: components: 'codec' (codec.fast): option "
                                                            "'level': 0 is too small; expected an integer of at least 1");
    CHECK(found("{codek: codec.fast}") == "p.yaml:2:14: error: no stage takes components of the kind 'codek' from the pipeline "
                                          "(did you mean 'codec'?)");
    CHECK(found("{loss: loss.gram}").starts_with("p.yaml:2:14: error: no stage takes components of the kind 'loss'"));
    CHECK(found("{codec: }") == "p.yaml:2:14: error: components: 'codec' has no value: leave the line out, or set {type: …} of "
                                "kind 'codec', or none");
    CHECK(found("[codec.fast]") == "p.yaml:2:13: error: 'components' must be a map {name: …}, got a list");
    CHECK(found("{codec: '${c}'}").starts_with("p.yaml:2:21: error: unknown var 'c'"));
    CHECK(found("{}", ", c: {type: picture.write, codec: codec.fast}")
              .starts_with("p.yaml:3:87: error: stage 'c' (picture.write) has no option 'codec'"));
    CHECK(found("{}", ", components: {type: picture.write}") ==
          "p.yaml:3:62: error: 'components' cannot name a stage: --set components.KIND=… sets the pipeline's components");
    CHECK(found("{}", "", {{"components.codek", "codec.fast"}})
              .starts_with("--set components.codek=codec.fast: error: no stage takes"));
    CHECK(
        found("{}", "", {{"components.codec.type", "codec.fast"}, {"components.codec.levl", "2"}}).find("has no option 'levl'") !=
        std::string::npos);
    CHECK(check(folder, "version: 1\ncomponents: {codec: codec.lost}\nstages: {b: {type: mesh.two}}\n", catalog).exit_code() ==
          2);
}

TEST_CASE("A var is checked whether it is used or not", "[pipeline]")
{
    const auto found = lines(check({}, "version: 1\nvars:\n  a: x\n  b: \"${nope}\"\n  c: \"${d}\"\n  d: \"${c}\"\n"
                                       "stages:\n  s: {type: mesh.two}\n"));
    REQUIRE(found.size() == 2);
    CHECK_THAT(found[0], Contains("p.yaml:4:6: error: unknown var 'nope'"));
    CHECK_THAT(found[1], Contains("cycle of vars: c → d → c"));
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
    catalog.add(UnbuiltPlugin{"loss.left", ""});
    struct Row
    {
        std::string stages;
        int exit_code;
        std::string words;
    };
    for (const Row& row : std::vector<Row>{
             {"a: {type: scan.folder, path: nowhere}", 3, "no such folder '" + (folder.path() / "nowhere").string() + "'"},
             {"a: {type: scan.folder, path: \"${data}\"}", 3,
              "p.yaml:3:39: error: the var 'data' has no value: set it with --set"},
             {"a: {type: scan.folder, path: file.txt}", 3, "is not a folder"},
             {"a: {type: mesh.pass, input: {file: folder.ply}}", 3, "is a folder, not a file"},
             {"a: {type: scan.folder, path: nowhere}, b: {type: mesh.twice}", 4,
              "/plugins/mesh.twice.so and /elsewhere/mesh_twice.so"},
             {"a: {type: mesh.broken}", 4, "is probably in /plugins/mesh_broken.so, which cannot be used: SDK ABI 2"},
             {"a: {type: mesh.odd}", 4, ""},
             {"a: {type: texture.heavy}", 4, "not built (libtorch was not found): run ./bootstrap build"},
             {"b: {type: loss.left}", 4, "not built: run ./bootstrap build"},
             {"a: {type: mesh.broken}, b: {type: nothing}", 2, ""}})
    {
        CAPTURE(row.stages);
        const PipelineResult result = check(folder, "version: 1\nvars: {data: }\nstages: {" + row.stages + "}\n", catalog);
        CHECK_THAT(joined_lines(result), Contains(row.words));
        CHECK(result.exit_code() == row.exit_code);
    }
}

TEST_CASE("A file that is not a pipeline is one clear problem", "[pipeline]")
{
    for (const auto& [text, problem] : std::vector<std::pair<std::string, std::string>>{
             {"", "p.yaml:1:1: error: the file is empty"},
             {"# nothing\n", "p.yaml:1:1: error: the file is empty"},
             {"- 1\n", "p.yaml:1:1: error: a pipeline is a map"},
             {"version: 1\n", "p.yaml:1:1: error: missing stages"},
             {"version: 1\nstages:\n", "p.yaml:1:1: error: missing stages"},
             {"version: 1\nstages: []\n", "p.yaml:2:9: error: 'stages' must be a map"},
             {"stages: {a: {type: mesh.two}}\n", "p.yaml:1:1: error: missing 'version: 1'"},
             {"version: 1\nstages: {a: {type: mesh.two}}\n---\n", "p.yaml:3:1: error: a second document"},
             {std::string(yaml_size_limit + 1, '#'), "p.yaml: error: larger than 1 MiB"}})
        CHECK_THAT(joined_lines(check({}, text)), StartsWith(problem) && !Contains(" | "));
    const TemporaryFolder folder;
    const PipelineResult missing = load_pipeline({"none.yaml", {}, folder.path()}, usual_catalog());
    CHECK_THAT(joined_lines(missing), StartsWith("none.yaml: error: no such pipeline file '"));
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
    for (int i = 0; i < 1000; ++i)
        text += fmt::format("  var_{:05}: 1\n", i);
    text += "stages:\n  p: {type: mesh.pass, title: 1}\n  list:\n    type: mesh.pass\n";
    for (int i = 0; i < 1000; ++i)
        text += fmt::format("    o{}: \"${{vor_{:05}}}\"\n", i, i);
    const Words told = lines(check({}, text));
    const auto with = [&](const std::string& part)
    { return std::ranges::count_if(told, [&](const std::string& line) { return line.find(part) != std::string::npos; }); };
    CHECK(with("unknown var 'vor_00000' (did you mean 'var_00000'?)") == 1);
    CHECK(with("unknown var 'vor_00999'") == 1);
    CHECK(with("unknown var 'vor_00999' (did") == 0);
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
    const std::string before = std::setlocale(LC_ALL, nullptr);
    if (!std::setlocale(LC_ALL, "de_DE.UTF-8") && !std::setlocale(LC_ALL, "fr_FR.UTF-8"))
        skipped("numbers of pipelines where a comma is the decimal point: there is no locale de_DE.UTF-8");
    struct Comma : std::numpunct<char>
    {
        char do_decimal_point() const override { return ','; }
        char do_thousands_sep() const override { return '.'; }
        std::string do_grouping() const override { return "\3"; }
    };
    const std::locale global_before = std::locale::global(std::locale(std::locale::classic(), new Comma));
    const PipelineResult result = check({}, "version: 1\nstages: {a: {type: mesh.pass, size: 1.5}}\n");
    const std::string problem = problem_of("a: {type: mesh.pass, size: 1,5}");
    const std::string range = problem_of("m: {type: mesh.two}\n  d: {type: mesh.decimate, input: m.left, max_faces: 2}");
    std::locale::global(global_before);
    std::setlocale(LC_ALL, before.c_str());
    CHECK(options_of(result, "a") == R"({"title":"","size":1.5})");
    CHECK_FALSE(problem.empty());
    CHECK_THAT(range, Contains("from 4 to 50000000"));
}

TEST_CASE("Only the words of a program have several lines; control characters are nowhere", "[pipeline]")
{
    for (const std::string text : {"\"a\\nb\"", "\"a\\tb\"", "|\n      a\n"})
        CHECK_THAT(problem_of("a: {type: mesh.pass}\n  b:\n    type: mesh.pass\n    title: " + text),
                   StartsWith("p.yaml:6:12: error: stage 'b' (mesh.pass): option 'title': ") &&
                       Contains("an end of line or a tab"));
    const TemporaryFolder folder;
    const std::string text = "version: 1\nstages:\n  a: {type: mesh.pass, title: x}\n";
    const auto set = [&](const std::string& name, const std::string& value) {
        return joined_lines(check(folder, text, usual_catalog(), {{name, value}}));
    };
    CHECK(set("a.title", "y").empty());
    CHECK_THAT(set("a.title", "y\x1b"), Contains(": error: control characters are not allowed"));
    CHECK_THAT(set("a.ti\x01tle", "y"), Contains(": error: control characters are not allowed"));
    CHECK_THAT(set("a.title", R"("y\0")"), StartsWith(R"(--set a.title="y\0": error: )") && Contains("control character"));
    CHECK_THAT(set("a.title", "y\nz"), Contains("an end of line or a tab"));
}

TEST_CASE("A mistake in what --set gives a var is reported there", "[pipeline]")
{
    const Room folder;
    const auto set = [&](const std::string& name, const std::string& value) {
        return joined_lines(check(folder, room, usual_catalog(), {{name, value}}));
    };
    CHECK_THAT(set("data", "scna"),
               StartsWith("--set data=scna: error: stage 'scan' (scan.folder): option 'path': no such folder '"));
    CHECK_THAT(set("picture", "pci.jpg"),
               StartsWith("--set picture=pci.jpg: error: stage 'texture' (texture.optimize): input 'style'"));
    CHECK_THAT(joined_lines(check(folder,
                                  "version: 1\nvars: {data: , size: }\nstages:\n  a: {type: mesh.pass, size: \"${size}\"}\n"
                                  "  s: {type: scan.folder, path: \"${data}/deep\"}\n",
                                  usual_catalog(), {{"data", "scan"}, {"size", "large"}})),
               StartsWith("--set data=scan: error: stage 's'") && Contains(" | --set size=large: error: stage 'a'"));
    // In the file, where the var is used.
    CHECK_THAT(
        joined_lines(check(folder, "version: 1\nvars: {data: scna}\nstages: {s: {type: scan.folder, path: \"${data}\"}}\n")),
        StartsWith("p.yaml:3:39: error: "));
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
    CHECK(names_of(load({"glb"})) == Words{"scan", "frames", "mesh", "uvmaps", "texture"});
    CHECK(names_of(load({"glb", "texture", "glb"})) == Words{"scan", "frames", "mesh", "uvmaps"});
    const Words read = lines(load({"mesh"}));
    REQUIRE(read.size() == 1);
    CHECK(read[0] ==
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
    CHECK(warnings(room).empty());
    CHECK(warnings(room + more) ==
          Words{"p.yaml:13:3: warning: no stage reads the result of 'mixed': name it as the input of one, or "
                "leave it out (--without mixed)"});
    CHECK(warnings(room + more, "mixed").empty());
    CHECK(warnings("version: 1\nstages:\n  mesh: {type: mesh.pass}\n" + more).empty());
    // Once for all combinations.
    CHECK(warnings(room + "  mixed: {type: mesh.pass, title: \"${weights}\"}\nmatrix: {weights: [vgg.st, pic.jpg]}\n").size() ==
          1);
}

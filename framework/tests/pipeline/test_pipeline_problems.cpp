#include "catch.h"
#include "hand_made_catalog.h"
#include "shared_data.h"

#include "pipeline/yaml_document.h"

#include <chrono>
#include <clocale>
#include <fmt/format.h>
#include <locale>

using namespace fresco::host;
using namespace fresco::host::testing;
using Catch::Contains;
using Catch::StartsWith;

namespace
{
/// The problems of one stage line, at line 3 of the file.
std::string problem_of(const std::string& stage, const std::string& more = {})
{
    const TemporaryFolder folder;
    const PipelineResult result = check(folder, "version: 1\nstages:\n  " + stage + "\n" + more, hand_made_catalog());
    std::string joined;
    for (const std::string& line : lines(result))
        joined += (joined.empty() ? "" : " | ") + line;
    return joined;
}
}  // namespace

TEST_CASE("Every problem is reported at once, in the file's order, with its place and what is right", "[pipeline]")
{
    const TemporaryFolder folder;
    const PipelineResult result = check(folder, R"(version: 2
var: {}
vars: {mesh: 1, a: "${b}", b: "${a}"}
stages:
  scan:    {type: scan.foldr, path: "${data}"}
  frames:  {type: frames.sharpest, input: scann, min_sharpnes: 150}
  mesh:    {type: mesh.decimate,   input: uvmaps, max_faces: 3, keep_borders: on, method: quadrik, method: x}
  uvmaps:  {type: uvmaps.raycast,  input: {mesh: &x frames.kep, frams: frames}, heights_px: 256, weights: [1, 010, .nan, x]}
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
)",
                                        hand_made_catalog());
    CHECK(result.pipeline.stages.empty());
    CHECK(result.exit_code() == 2);
    const std::vector<std::string> expected{
        "p.yaml:1:10: error: version must be 1, got 2",
        "p.yaml:2:1: error: unknown key 'var' (did you mean 'vars'?)",
        "p.yaml:3:8: error: the var 'mesh' has the name of the stage on line 7: rename one of them, so that --set mesh is "
        "unambiguous",
        "p.yaml:3:31: error: cycle of vars: a → b → a",
        "p.yaml:5:19: error: stage 'scan': unknown type 'scan.foldr' (did you mean 'scan.folder'?)",
        "p.yaml:5:37: error: unknown var 'data' (there are: a, b, mesh)",
        "p.yaml:6:43: error: stage 'frames' (frames.sharpest): unknown stage 'scann' (did you mean 'scan'?)",
        "p.yaml:6:50: error: stage 'frames' (frames.sharpest) has no option 'min_sharpnes' (did you mean 'min_sharpness'?)",
        "p.yaml:7:43: error: stage 'mesh' (mesh.decimate): input 'mesh' takes mesh, but stage 'uvmaps' (uvmaps.raycast) makes "
        "maps (uv_maps)",
        "p.yaml:7:62: error: stage 'mesh' (mesh.decimate): option 'max_faces': 3 is too small; expected an integer from 4 to "
        "50000000",
        "p.yaml:7:79: error: stage 'mesh' (mesh.decimate): option 'keep_borders': expected true or false, got the text 'on' "
        "(write true)",
        "p.yaml:7:91: error: stage 'mesh' (mesh.decimate): option 'method': 'quadrik' is not known (did you mean 'quadric'?); "
        "expected one of quadric, edge",
        "p.yaml:7:100: error: the key 'method' appears twice; the first is on line 7",
        "p.yaml:8:50: error: anchors (&x) are not allowed in a pipeline file: use a var",
        "p.yaml:8:50: error: stage 'uvmaps' (uvmaps.raycast): stage 'frames' (frames.sharpest) has no output 'kep' (did you mean "
        "'kept'?)",
        "p.yaml:8:65: error: stage 'uvmaps' (uvmaps.raycast) has no input 'frams' (did you mean 'frames'?)",
        "p.yaml:8:93: error: stage 'uvmaps' (uvmaps.raycast): option 'heights_px': expected a list, each entry an integer from "
        "16 to 4096, got 256 (write [256])",
        "p.yaml:8:111: error: stage 'uvmaps' (uvmaps.raycast): option 'weights': '010' begins with 0, which some readers take "
        "for octal: write it without the 0, or '010' in quotes for text; expected a list, each entry a number",
        "p.yaml:8:116: error: stage 'uvmaps' (uvmaps.raycast): option 'weights': '.nan' is not a finite number; expected a list, "
        "each entry a number",
        "p.yaml:8:122: error: stage 'uvmaps' (uvmaps.raycast): option 'weights': expected a list, each entry a number, got the "
        "text 'x'",
        "p.yaml:12:21: error: stage 'texture' (texture.optimize): option 'losses.style': unknown type 'loss.gran' (did "
        "you mean 'loss.gram'?)",
        "p.yaml:12:70: error: stage 'texture' (texture.optimize): option 'losses.b' (loss.gram): option 'features': 'loss.gram' "
        "is of kind 'loss'; expected kind 'features' (there are: features.edges, features.vgg)",
        "p.yaml:13:31: error: cycle: p → p",
        "p.yaml:13:41: error: stage 'p' (mesh.pass): option 'title': expected text, got 42 (write '42' in quotes)",
        "p.yaml:13:45: error: stage 'p' (mesh.pass): option 'size' has no value: leave the line out for the default, 1.0, or "
        "set a number",
        "p.yaml:14:3: error: stage 'q' must be a map {type: …, option: …}, got nothing",
        "p.yaml:15:3: error: '1r' cannot name a stage: a name has letters, digits, '_' and '-' and begins with a letter or '_'",
        "p.yaml:16:25: error: stage 'two' (mesh.two) takes no input",
        "p.yaml:17:31: error: stage 't' (mesh.pass): 'two' is ambiguous: name the port: {mesh: two.left} or "
        "{mesh: two.right}",
        "p.yaml:18:40: error: stage 'f' (mesh.future): input 'mesh' takes mesh (version 2), but output 'right' of stage 'two' "
        "(mesh.two) is mesh",
        "p.yaml:19:3: error: stage 'g' (mesh.decimate) needs the input 'mesh' (mesh); it is made by mesh.simplified, p.mesh, "
        "1r.mesh, two.left, two.right and t.mesh",
        "p.yaml:20:3: error: stage 'h' (scan.folder) needs the option 'path': the path of an existing folder (Folder of the "
        "scan)"};
    CHECK(lines(result) == expected);
}

TEST_CASE("A missing input is not offered what would close a cycle", "[pipeline]")
{
    CHECK_THAT(problem_of("a: {type: mesh.decimate}", "  b: {type: mesh.pass, input: a}\n  c: {type: mesh.pass, input: b}\n"),
               Contains("needs the input 'mesh' (mesh); no stage of this pipeline makes mesh"));
}

TEST_CASE("Values of the wrong type are named with what is accepted and what was probably meant", "[pipeline]")
{
    CHECK_THAT(problem_of("a: {type: mesh.pass, size: '5'}"),
               Contains("3:30: error:") && Contains("got the text '5' (without the quotes)"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, size: \"0,5\"}"), Contains("(write 0.5)"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, size: [1]}"), Contains("expected a number, got a list"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, size: {b: 1}}"), Contains("expected a number, got a map"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, title: true}"), Contains("expected text, got true (write 'true' in quotes)"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, size: .inf}"), Contains("'.inf' is not a finite number; expected a number"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, size: nan}"), Contains("got the text 'nan'"));
    CHECK_THAT(problem_of("a: {type: mesh.two, x: 1}"), Contains("has no option 'x': it has none"));
    CHECK_THAT(problem_of("m: {type: mesh.two}", "  d: {type: mesh.decimate, input: m.left, max_faces: 1e6}\n"),
               Contains("(write 1000000)"));
    CHECK_THAT(problem_of("m: {type: mesh.two}", "  d: {type: mesh.decimate, input: m.left, keep_borders: 1}\n"),
               Contains("(write true)"));
    CHECK_THAT(problem_of("a: {type: export.gltf, path: ../x.glb}"),
               Contains("'../x.glb' is not accepted; expected a relative path below --out"));
    CHECK_THAT(problem_of("a: {type: export.gltf, path: /x.glb}"), Contains("'/x.glb' is not accepted"));
    const auto height = [](const std::string& text)
    { return problem_of("a: {type: uvmaps.raycast, input: b, heights_px: [" + text + "]}", "  b: {type: nothing}\n"); };
    CHECK_THAT(height("4097"), Contains("4097 is too large; expected a list, each entry an integer from 16 to 4096"));
    CHECK_THAT(height("15"), Contains("15 is too small"));
    CHECK_THAT(height("16, 4096"), !Contains("heights_px"));
    CHECK_THAT(problem_of("a: {title: x}"), Contains("3:3: error: stage 'a': missing 'type'"));
    CHECK_THAT(problem_of("a: {typ: mesh.pass}"), Contains("missing 'type' (is 'typ' meant to be it?)"));
    CHECK_THAT(problem_of("s: {type: scan.folder, path: .}\n  u: {type: uvmaps.raycast, input: s.mesh}"),
               Contains("needs the input 'frames' (frames); it is made by s.frames"));
    CHECK_THAT(problem_of("a: {type: 5}"), Contains("expected a type such as 'mesh.decimate', got 5"));
    CHECK_THAT(problem_of("a: [1]"), Contains("stage 'a' must be a map"));
    CHECK_THAT(problem_of("a: {type: loss.gram}"), Contains("'loss.gram' is of kind 'loss'; expected kind 'stage'"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, title: \"${x\"}"), Contains("a '${' is not closed"));
}

TEST_CASE("Inputs that do not fit are named with what there is", "[pipeline]")
{
    CHECK_THAT(problem_of("a: {type: mesh.pass, input: [b]}"),
               Contains("must be a stage's name, {port: stage, …} or {file: PATH}, got a list"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, input: }"), Contains("3:24: error: stage 'a' (mesh.pass): 'input' has no value"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, input: room.ply}"),
               Contains("unknown stage 'room'") && Contains("a file is written {file: room.ply}"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, input: {mesh: {fil: x}}}"),
               Contains("must be a stage's name or {file: PATH}, got a map"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, input: {file: x.ply}}"), Contains("3:38: error: ") && Contains("no such file '"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, input: {file: x.ply, type: read.image}}"),
               Contains("'read.image' makes no mesh"));
    CHECK_THAT(problem_of("a: {type: mesh.pass, input: {file: x.ply, depth: 1}}"), Contains("has no option 'depth'"));
    CHECK_THAT(problem_of("a: {type: mesh.decimate, input: {file: ''}}"),
               Contains("needs the input 'mesh' (mesh); no stage of this pipeline makes mesh"));
    CHECK_THAT(problem_of("a: {type: frames.sharpest}", "  b: {type: mesh.two}\n"),
               Contains("needs the input 'frames' (frames); no stage of this pipeline makes frames"));
    CHECK_THAT(problem_of("a: {type: uvmaps.raycast, input: a}"),
               Contains("takes mesh (mesh) and frames (frames), but stage 'a' (uvmaps.raycast) makes maps (uv_maps)"));
}

TEST_CASE("A var is checked whether it is used or not", "[pipeline]")
{
    const TemporaryFolder folder;
    const Catalog catalog = hand_made_catalog();
    const std::vector<std::string> found =
        lines(check(folder,
                    "version: 1\nvars:\n  a: x\n  b: \"${nope}\"\n  c: \"${d}\"\n  d: \"${c}\"\n"
                    "stages:\n  s: {type: mesh.two}\n",
                    catalog));
    REQUIRE(found.size() == 2);
    CHECK_THAT(found[0], Contains("p.yaml:4:6: error: unknown var 'nope'"));
    CHECK_THAT(found[1], Contains("cycle of vars: c → d → c"));
}

TEST_CASE("Two stages do not write one file", "[pipeline]")
{
    const std::string two =
        problem_of("t: {type: texture.optimize, preview: room.glb}",
                   "  a: {type: export.gltf, input: t}\n  b: {type: export.gltf, input: t, path: x/../room.glb}\n");
    CHECK_THAT(
        two,
        Contains("p.yaml:4:3: error: the stages t and a would both write room.glb below --out: give one of them another path"));
    CHECK_THAT(two, Contains("stage 'b' (export.gltf): option 'path': 'x/../room.glb' is not accepted"));
    const std::string below = problem_of(
        "t: {type: texture.optimize, preview: a}",
        "  a: {type: export.gltf, input: t, path: a/b.glb}\n  b: {type: export.gltf, input: t, path: a/b.glb/c.glb}\n");
    CHECK_THAT(below,
               Contains("p.yaml:5:42: error: the stage a would write the file a/b.glb below --out, and the stage b would write "
                        "a/b.glb/c.glb"));
    // Several may write into one folder.
    CHECK(below.find("stage t would") == std::string::npos);
}

TEST_CASE("What is missing, and which plugin fails, leads to its own exit code", "[pipeline]")
{
    const TemporaryFolder folder;
    Catalog catalog = hand_made_catalog();
    catalog.add(described("mesh.twice", "stage", R"({"options": []})"));
    TypeDescription other = described("mesh.twice", "stage", R"({"options": []})");
    other.library = "/elsewhere/mesh_twice.so";
    catalog.add(other);
    catalog.add(Refusal{"/plugins/mesh_broken.so", "SDK ABI 2, this program has 1"});
    catalog.add(described("mesh.odd", "stage", R"({"options": [{"name": "x", "kind": "color"}]})"));
    const auto code = [&](const std::string& stages) { return check(folder, "version: 1\nstages: {" + stages + "}\n", catalog); };
    const PipelineResult missing = code("a: {type: scan.folder, path: nowhere}");
    CHECK_THAT(lines(missing).at(0), Contains("no such folder '" + (folder.path() / "nowhere").string() + "'"));
    CHECK(missing.exit_code() == 3);
    const PipelineResult twice = code("a: {type: scan.folder, path: nowhere}, b: {type: mesh.twice}");
    CHECK_THAT(lines(twice).at(1), Contains("several plugins have the type 'mesh.twice'") &&
                                       Contains("/plugins/mesh.twice.so and /elsewhere/mesh_twice.so"));
    CHECK(twice.exit_code() == 4);
    const PipelineResult broken = code("a: {type: mesh.broken}");
    CHECK_THAT(lines(broken).at(0),
               Contains("'mesh.broken' is probably in /plugins/mesh_broken.so, which cannot be used: SDK ABI 2"));
    CHECK(broken.exit_code() == 4);
    CHECK(code("a: {type: mesh.odd}").exit_code() == 4);
    catalog.add(UnbuiltPlugin{"texture.heavy", "libtorch was not found"});
    catalog.add(UnbuiltPlugin{"loss.left", ""});
    const PipelineResult unbuilt = code("a: {type: texture.heavy, input: b}, b: {type: loss.left}");
    CHECK(lines(unbuilt) == std::vector<std::string>{
                                "p.yaml:2:20: error: stage 'a': the plugin of 'texture.heavy' is not built (libtorch was not "
                                "found): run ./bootstrap build",
                                "p.yaml:2:56: error: stage 'b': the plugin of 'loss.left' is not built: run ./bootstrap build"});
    CHECK(unbuilt.exit_code() == 4);
    CHECK(code("a: {type: mesh.broken}, b: {type: nothing}").exit_code() == 2);
    folder.write("file.txt", "");
    CHECK_THAT(lines(code("a: {type: scan.folder, path: file.txt}")).at(0), Contains("is not a folder"));
    std::filesystem::create_directory(folder.path() / "folder.ply");
    CHECK_THAT(lines(code("a: {type: mesh.pass, input: {file: folder.ply}}")).at(0), Contains("is a folder, not a file"));
    const PipelineResult unset =
        check(folder, "version: 1\nvars: {data: }\nstages: {a: {type: scan.folder, path: \"${data}\"}}\n", catalog);
    CHECK_THAT(lines(unset).at(0), Contains("p.yaml:3:39: error: the var 'data' has no value: set it with --set data=…"));
    CHECK(unset.exit_code() == 3);
}

TEST_CASE("A file that is not a pipeline is one clear problem", "[pipeline]")
{
    const TemporaryFolder folder;
    const Catalog catalog = hand_made_catalog();
    const auto only = [&](const std::string& text)
    {
        const PipelineResult result = check(folder, text, catalog);
        return result.problems.size() == 1 ? lines(result)[0]
                                           : "there are " + std::to_string(result.problems.size()) + " problems";
    };
    CHECK_THAT(only(""), StartsWith("p.yaml:1:1: error: the file is empty"));
    CHECK_THAT(only("# nothing\n"), StartsWith("p.yaml:1:1: error: the file is empty"));
    CHECK_THAT(only("- 1\n"), StartsWith("p.yaml:1:1: error: a pipeline is a map"));
    CHECK_THAT(only("version: 1\n"), StartsWith("p.yaml:1:1: error: missing stages"));
    CHECK_THAT(only("version: 1\nstages:\n"), StartsWith("p.yaml:1:1: error: missing stages"));
    CHECK_THAT(only("version: 1\nstages: []\n"), StartsWith("p.yaml:2:9: error: 'stages' must be a map"));
    CHECK_THAT(only("stages: {a: {type: mesh.two}}\n"), StartsWith("p.yaml:1:1: error: missing 'version: 1'"));
    CHECK_THAT(only("version: 1\nstages: {a: {type: mesh.two}}\n---\n"), StartsWith("p.yaml:3:1: error: a second document"));
    CHECK_THAT(only(std::string(yaml_size_limit + 1, '#')), StartsWith("p.yaml: error: larger than 1 MiB"));

    const PipelineResult missing = load_pipeline({"none.yaml", {}, folder.path()}, catalog);
    CHECK_THAT(lines(missing).at(0), StartsWith("none.yaml: error: no such pipeline file '"));
    CHECK(missing.exit_code() == 3);
    CHECK_THAT(lines(load_pipeline({folder.path(), {}, {}}, catalog)).at(0), Contains("is not a regular file"));
}

TEST_CASE("A cycle of 1 000 stages is one short problem, at once", "[pipeline]")
{
    std::string text = "version: 1\nstages:\n";
    for (int i = 0; i < 1000; ++i)
        text += "  s" + std::to_string(i) + ": {type: mesh.pass, input: s" + std::to_string((i + 999) % 1000) + "}\n";
    const TemporaryFolder folder;
    const auto start = std::chrono::steady_clock::now();
    const PipelineResult result = check(folder, text, hand_made_catalog());
    REQUIRE(result.problems.size() == 1);
    CHECK(lines(result)[0] == "p.yaml:3:32: error: cycle: s0 → s1 → s2 → s3 → s4 → s5 → s6 → s7 → … (1000 stages) → s0");
    CHECK(result.exit_code() == 2);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(5));
}

TEST_CASE("Only the first mistakes of a file get hints: hints for all take minutes", "[pipeline]")
{
    std::string text = "version: 1\nvars:\n";
    for (int i = 0; i < 1000; ++i)
        text += fmt::format("  var_{:05}: 1\n", i);
    text += "stages:\n  p: {type: mesh.pass, title: 1}\n  list:\n    type: mesh.pass\n";
    for (int i = 0; i < 1000; ++i)
        text += fmt::format("    o{}: \"${{vor_{:05}}}\"\n", i, i);
    const TemporaryFolder folder;
    const auto told = lines(check(folder, text, hand_made_catalog()));
    const auto with = [&](const std::string& part)
    { return std::ranges::count_if(told, [&](const std::string& line) { return line.find(part) != std::string::npos; }); };
    CHECK(with("unknown var 'vor_00000' (did you mean 'var_00000'?)") == 1);
    CHECK(with("unknown var 'vor_00999'") == 1);
    CHECK(with("unknown var 'vor_00999' (did") == 0);
}

TEST_CASE("Vars that grow without bound are refused", "[pipeline]")
{
    std::string text = "version: 1\nvars:\n  v0: xxxxxxxxxxxxxxxx\n";
    for (int i = 1; i < 30; ++i)
    {
        const std::string before = "${v" + std::to_string(i - 1) + "}";
        text += "  v" + std::to_string(i) + ": \"" + before + before + before + "\"\n";
    }
    text += "stages: {a: {type: mesh.pass, title: \"${v29}\"}}\n";
    const TemporaryFolder folder;
    const auto result = lines(check(folder, text, hand_made_catalog()));
    REQUIRE_FALSE(result.empty());
    CHECK_THAT(result[0], Contains("the vars grow to more than 4 MiB"));

    std::string lists = "version: 1\nvars:\n  v0: [x]\n";
    for (int i = 1; i < 40; ++i)
        lists += "  v" + std::to_string(i) + ": [\"${v" + std::to_string(i - 1) + "}\"]\n";
    CHECK_FALSE(
        check(folder, lists + "stages: {a: {type: mesh.pass, title: \"${v39}\"}}\n", hand_made_catalog()).problems.empty());
}

TEST_CASE("Numbers are read alike where a comma is the decimal point", "[pipeline]")
{
    const std::string before = std::setlocale(LC_ALL, nullptr);
    const bool comma =
        std::setlocale(LC_ALL, "de_DE.UTF-8") || std::setlocale(LC_ALL, "de_DE.utf8") || std::setlocale(LC_ALL, "fr_FR.UTF-8");
    if (!comma)
        skipped("numbers of pipelines where a comma is the decimal point: there is no locale de_DE.UTF-8");
    struct Comma : std::numpunct<char>
    {
        char do_decimal_point() const override { return ','; }
        char do_thousands_sep() const override { return '.'; }
        std::string do_grouping() const override { return "\3"; }
    };
    const std::locale global_before = std::locale::global(std::locale(std::locale::classic(), new Comma));
    const TemporaryFolder folder;
    const PipelineResult result = check(folder, "version: 1\nstages: {a: {type: mesh.pass, size: 1.5}}\n", hand_made_catalog());
    const std::string problem = problem_of("a: {type: mesh.pass, size: 1,5}");
    const std::string range = problem_of("m: {type: mesh.two}", "  d: {type: mesh.decimate, input: m.left, max_faces: 2}\n");
    std::locale::global(global_before);
    std::setlocale(LC_ALL, before.c_str());
    REQUIRE(lines(result).empty());
    CHECK(result.pipeline.find("a")->options->at("size") == fresco::Value(1.5));
    CHECK_FALSE(problem.empty());
    CHECK_THAT(range, Contains("from 4 to 50000000"));
}

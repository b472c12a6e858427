#include "catch.h"
#include "hand_made_catalog.h"

#include "pipeline/pipeline_options.h"
#include <fresco/file_access.h>

// Loading of pipeline files: options, wires, vars, --set, bases, previews. Problems: test_pipeline_problems.cpp.

using namespace fresco::host;
using namespace fresco::host::testing;
using fresco::Value;

namespace
{

using Files = std::vector<std::filesystem::path>;

/// "PORT from STAGE.PORT" or "PORT from FILE" for each wire of a stage.
Words wires_of(const PipelineResult& result, const char* stage)
{
    Words texts;
    for (const Wire& wire : result.pipeline.find(stage)->wires)
        texts.push_back(wire.port + " from " +
                        (wire.from_stage.empty() ? wire.file.filename().string() : wire.from_stage + "." + wire.from_port));
    return texts;
}

TypeDescription painter(const Value& versions)
{
    TypeDescription type =
        stage("paint", "", "", R"({"name": "device", "kind": "text", "default": "auto", "device": true, "help": ""})");
    type.library_versions = versions;
    return type;
}

}  // namespace

TEST_CASE("A pipeline is completed down to the options of its components", "[pipeline]")
{
    const Room folder;
    const PipelineResult result = check(folder, room);
    REQUIRE(lines(result).empty());
    CHECK(names_of(result) == Words{"scan", "frames", "mesh", "uvmaps", "texture", "glb"});
    CHECK(options_of(result, "mesh") == R"({"max_faces":400000,"keep_borders":true,"method":"quadric"})");
    // A whole number for a number is a number: 150 and 150.0 are one cache key.
    CHECK(options_of(result, "frames") == R"({"min_sharpness":150.0})");
    CHECK(options_of(result, "scan") == R"({"path":")" + (folder.path() / "scan").string() + R"(","every":1})");
    // An empty output name and an optional slot are left out.
    CHECK(options_of(result, "texture") ==
          R"({"size_px":2048,"epochs":2,"max_steps":0,"weights":"","losses":{"style":)"
          R"({"type":"loss.gram","weight":2.0,"features":{"type":"features.edges","seed":1}}}})");
    const PipelineStage& texture = *result.pipeline.find("texture");
    CHECK(wires_of(result, "texture") == Words{"maps from uvmaps.maps", "frames from frames.kept", "style from pic.jpg"});
    CHECK(fresco::to_json(texture.wires[2].reader) == R"({"type":"read.image","max_px":100})");
    CHECK(texture.input_files == Files{folder.path() / "pic.jpg"});
    CHECK(each(texture.components, &TypeDescription::type) == Words{"features.edges", "loss.gram", "read.image"});

    // Files of the stage and of its components.
    const PipelineResult weighted =
        check(folder, room + "    losses: {a: {type: loss.gram, features: {type: features.vgg, weights: vgg.st}}}\n");
    CHECK(weighted.pipeline.find("texture")->input_files == Files{folder.path() / "pic.jpg", folder.path() / "vgg.st"});
}

TEST_CASE("Components are written as a type, with or without options, in any order; none leaves a slot empty that may be",
          "[pipeline]")
{
    const Room folder;
    const auto losses = [&](const std::string& text)
    { return options_of(check(folder, room + "    losses: " + text + "\n"), "texture"); };
    const std::string by_word = losses("{b: loss.content, a: {type: loss.gram, features: features.edges}}");
    CHECK(by_word ==
          losses("{a: {features: {seed: 1, type: features.edges}, weight: 1, type: loss.gram}, b: {type: loss.content}}"));
    CHECK_THAT(by_word, Contains(R"("losses":{"a":{"type":"loss.gram","weight":1.0,"features":)"));
    CHECK_THAT(losses("{}"), Contains(R"("losses":{})"));

    const auto judged = [&](const std::string& options)
    { return options_of(check(folder, "version: 1\nstages: {a: {type: mesh.judged" + options + "}}\n"), "a"); };
    const std::string needed = R"("needed":{"type":"loss.content","weight":70.0}})";
    CHECK(judged("") == R"({"loss":{"type":"loss.content","weight":70.0},)" + needed);
    CHECK(judged(", loss: none") == "{" + needed);
    CHECK_THAT(judged(", needed: none"), Contains("unknown type 'none' (there are: loss.content, loss.gram)"));
    CHECK_THAT(judged(", loss: [1]"), Contains("or none, got a list"));
}

TEST_CASE("A pipeline chooses the components that its stages share", "[pipeline]")
{
    const TemporaryFolder folder;
    const Catalog catalog = catalog_with_codecs();
    const std::string stages = "stages: {a: {type: picture.write}, b: {type: picture.peek}}\n";
    const std::string plain = R"({"type":"codec.plain"})", fast = R"({"type":"codec.fast","level":)";
    folder.write("base.yaml", "version: 1\ncomponents: {codec: {type: codec.fast, level: 2}}\n" + stages);
    struct Row
    {
        std::string text, codec;
        Sets sets = {};
    };
    for (const Row& row : std::vector<Row>{
             {stages, plain},
             {"components: {codec: {type: codec.fast, level: 7}}\n" + stages, fast + "7}"},
             {"vars: {c: codec.fast}\ncomponents: {codec: '${c}'}\n" + stages, plain, {{"c", "codec.plain"}}},
             {"components: {codec: codec.plain}\n" + stages, fast + "3}", {{"components.codec", "codec.fast"}}},
             {"components: {codec: codec.fast}\n" + stages, fast + "5}", {{"components.codec.level", "5"}}},
             {stages, fast + "3}", {{"components.codec.type", "codec.fast"}}},
             {stages, "did you mean 'level'?", {{"components.codec.type", "codec.fast"}, {"components.codec.levl", "2"}}},
             // A file goes before its base, and an empty value removes the base's choice.
             {"base: base.yaml\n", fast + "2}"},
             {"base: base.yaml\ncomponents: {codec: {level: 9}}\n", fast + "9}"},
             {"base: base.yaml\ncomponents: {codec: codec.plain}\n", plain},
             {"base: base.yaml\ncomponents: {codec: }\n", plain}})
    {
        const PipelineResult result = check(folder, "version: 1\n" + row.text, catalog, row.sets);
        CHECK_THAT(options_of(result, "a"), Contains(row.codec));
        CHECK(options_of(result, "b") == options_of(result, "a"));
    }
    const std::string none = "version: 1\ncomponents: {codec: none}\nstages: {b: {type: picture.peek}}\n";
    CHECK(options_of(check(folder, none, catalog), "b") == "{}");

    // An axis may decide it.
    const PipelineResult sweep =
        check(folder,
              "version: 1\nvars: {c: }\nmatrix: {c: {one: codec.plain, two: codec.fast}}\ncomponents: {codec: '${c}'}\n" + stages,
              catalog);
    CHECK(options_of(sweep, "a@two") == "{\"codec\":" + fast + "3}}");
}

TEST_CASE("A stage's name wires every input that one of its outputs fits in one way; ports may be named", "[pipeline]")
{
    const Room folder;
    folder.write("m.ply", ply_text);
    const PipelineResult result = check(folder, R"(version: 1
stages:
  two:  {type: mesh.two}
  a:    {type: mesh.pass, input: two.left}
  b:    {type: mesh.pass, input: {mesh: two.right}}
  c:    {type: mesh.pass, input: {file: m.ply}}
  d:    {type: mesh.pass, input: {mesh: {file: "", type: read.mesh}}}
  e:    {type: mesh.pass}
  scan: {type: scan.folder, path: .}
  kept: {type: frames.sharpest, input: scan}
  maps: {type: uvmaps.raster,  input: scan}
)");
    REQUIRE(lines(result).empty());
    CHECK(wires_of(result, "a") == Words{"mesh from two.left"});
    CHECK(wires_of(result, "b") == Words{"mesh from two.right"});
    CHECK(wires_of(result, "c") == Words{"mesh from m.ply"});
    CHECK(wires_of(result, "d").empty());
    CHECK(wires_of(result, "e").empty());
    CHECK(wires_of(result, "kept") == Words{"frames from scan.frames"});
    CHECK(wires_of(result, "maps") == Words{"mesh from scan.mesh", "frames from scan.frames"});
}

TEST_CASE("Vars keep their type, and paths count from where they were written", "[pipeline]")
{
    const Room folder;
    folder.write("sub/scan/x.png", "1");
    folder.write("work/other/y.png", "1");
    folder.write("sub/p.yaml", R"(version: 1
vars: {root: scan, faces: 1000, heights: [16, 32], deep: "${root}", name: room}
stages:
  scan:   {type: scan.folder, path: "${deep}"}
  mesh:   {type: mesh.decimate, input: scan, max_faces: "${faces}"}
  uv:     {type: uvmaps.raster,  input: {mesh: mesh, frames: scan}, heights_px: "${heights}"}
  again:  {type: scan.folder, path: "${root}/../${root}"}
  note:   {type: mesh.pass, title: "${name}s of $${name} cost 5$"}
)");
    const auto load = [&](const Sets& sets) {
        return load_pipeline({folder.path() / "sub/p.yaml", sets, folder.path() / "work"}, usual_catalog());
    };
    const PipelineResult result = load({});
    REQUIRE(lines(result).empty());
    const auto option = [](const PipelineResult& of, const char* stage, const char* name)
    { return of.pipeline.find(stage)->options->at(name); };
    const auto path = [&](const char* name) { return Value((folder.path() / name).string()); };
    CHECK(option(result, "scan", "path") == path("sub/scan"));
    CHECK(option(result, "again", "path") == path("sub/scan"));
    CHECK(option(result, "mesh", "max_faces") == Value(1000));
    CHECK(option(result, "uv", "heights_px") == Value(Value::List{16, 32}));
    CHECK(option(result, "note", "title") == Value("rooms of ${name} cost 5$"));

    const PipelineResult set = load({{"root", "other"}, {"faces", "7"}, {"heights", "[64]"}, {"note.title", "${name}: 010"}});
    REQUIRE(lines(set).empty());
    CHECK(option(set, "scan", "path") == path("work/other"));
    CHECK(option(set, "again", "path") == path("work/other"));
    CHECK(option(set, "note", "title") == Value("room: 010"));
    CHECK_THAT(joined_lines(load({{"root", "nowhere"}})), StartsWith("--set root=nowhere: error: stage 'scan'"));
    // A path given to an option on the command line counts from the working directory.
    CHECK(lines(load({{"scan.path", "other"}})).empty());
    CHECK_FALSE(lines(load({{"scan.path", "scan"}})).empty());
}

TEST_CASE("--set reaches into components, also those that are only defaults", "[pipeline]")
{
    const Room folder;
    for (const auto& [sets, found] : std::vector<std::pair<Sets, std::string>>{
             {{{"texture.losses.style.weight", "5"}}, R"("style":{"type":"loss.gram","weight":5.0)"},
             {{{"texture.losses.style.features.seed", "9"}}, R"({"type":"features.edges","seed":9})"},
             {{{"texture.losses.more.type", "loss.content"}, {"texture.losses.more.weight", "4"}},
              R"("more":{"type":"loss.content","weight":4.0},"style")"},
             {{{"texture.losses", "{one: {type: loss.content, weight: 1}}"}},
              R"("losses":{"one":{"type":"loss.content","weight":1.0}}})"},
             // Another type takes nothing over from the old one's options.
             {{{"texture.losses.style.features.seed", "9"}, {"texture.losses.style.type", "loss.content"}},
              R"("style":{"type":"loss.content","weight":70.0})"},
             {{{"texture.losses.stile.weight", "5"}},
              "--set texture.losses.stile.weight=5: error: stage 'texture' (texture.optimize): option 'losses.stile': missing"},
             {{{"texture.losses.style.wieght.a", "5"}}, "has no option 'wieght' (did you mean 'weight'?)"},
             {{{"texture.size_px.deep", "5"}}, "option 'size_px': expected an integer from 0 to 16384, got a map"},
             {{{"uvmaps.heights_px.deep", "5"}}, "'uvmaps.heights_px' is a list in the file, not a map with 'deep'"},
             {{{"texture.rule.speed", "5"}}, "option 'rule': missing 'type'"},
             {{{"texture.lozzes.style.weight", "5"}}, "has no option 'lozzes' (did you mean 'losses'?)"},
             {{{"texture.input.style.file", "vgg.st"}}, "no reader makes image from 'vgg.st'; expected .jpg or .png"},
             {{{"dat", "x"}}, "--set dat=x: error: unknown var 'dat' in the pipeline (did you mean 'data'?)"},
             {{{"mesh", "x"}}, "'mesh' is a stage"},
             {{{"mehs.max_faces", "5"}}, "unknown stage 'mehs' (did you mean 'mesh'?)"},
             {{{"mesh.max_faces", "[1"}}, "--set mesh.max_faces=[1: error: a '[' is not closed"},
             {{{"mesh..x", "1"}}, "expected NAME=VALUE"},
             {{{"picture", "no.jpg"}},
              "--set picture=no.jpg: error: stage 'texture' (texture.optimize): input 'style': no such file '"}})
    {
        const PipelineResult result = check(folder, room, usual_catalog(), sets);
        CHECK(result.problems.size() <= 1);
        CHECK_THAT(options_of(result, "texture"), Contains(found));
    }
    const PipelineResult wired =
        check(folder, room, usual_catalog(), {{"uvmaps.input.mesh", "scan"}, {"mesh.type", "mesh.pass"}});
    // The input stays when a stage's type changes, its options go.
    CHECK(options_of(wired, "mesh") == R"({"title":"","size":1.0})");
    CHECK(wires_of(wired, "mesh") == Words{"mesh from scan.mesh"});
    CHECK(wires_of(wired, "uvmaps").front() == "mesh from scan.mesh");
}

TEST_CASE("A pipeline file can build on another", "[pipeline]")
{
    const Room folder;
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
)");
    REQUIRE(lines(result).empty());
    CHECK(names_of(result) == Words{"scan", "frames", "mesh", "uvmaps", "texture", "extra"});
    CHECK(options_of(result, "mesh") == R"({"max_faces":9,"keep_borders":true,"method":"quadric"})");
    // frames.sharpest gave way to a type that takes a mesh, and still gets the scan.
    CHECK(options_of(result, "frames") == R"({"title":"new","size":1.0})");
    CHECK(wires_of(result, "frames") == Words{"mesh from scan.mesh"});
    CHECK(wires_of(result, "uvmaps") == Words{"mesh from mesh.simplified", "frames from scan.frames"});
    // The var of this file counts from this file, the base's from the base.
    CHECK(result.pipeline.find("texture")->wires.at(2).file == folder.path() / "pic.jpg");
    CHECK(result.pipeline.find("scan")->options->at("path") == Value((folder.path() / "presets/scan").string()));
    CHECK(result.pipeline.find("mesh")->position.line == 5);
    CHECK(result.pipeline.find("scan")->position.file == "presets/room.yaml");

    folder.write("presets/bad.yaml", "version: 1\nstages:\n  mesh: {type: mesh.decimat}\n");
    const auto bad = lines(check(folder, "version: 1\nbase: presets/bad.yaml\nstages:\n  other: {type: mesh.pas}\n  gone:\n"));
    REQUIRE(bad.size() == 3);
    CHECK_THAT(bad[0], StartsWith("p.yaml:4:17: error: stage 'other': unknown type 'mesh.pas'"));
    CHECK_THAT(bad[1], StartsWith("p.yaml:5:3: error: an empty value removes"));
    CHECK_THAT(bad[2], StartsWith("presets/bad.yaml:3:16: error: stage 'mesh': unknown type"));
    folder.write("a.yaml", "version: 1\nbase: p.yaml\n");
    CHECK_THAT(joined_lines(check(folder, "version: 1\nbase: ./a.yaml\n")),
               Contains(":2:7: error: more than 16 nested base files"));
    const PipelineResult missing = check(folder, "version: 1\nbase: none.yaml\n");
    CHECK_THAT(joined_lines(missing), StartsWith("p.yaml:2:7: error: no such pipeline file '"));
    CHECK(missing.exit_code() == 3);
}

TEST_CASE("A base is beside the file, or an installed pipeline of the name", "[pipeline]")
{
    const Room folder;
    const std::string over = "version: 1\nbase: photo_texture.yaml\nstages:\n  scan: {type: scan.folder, path: scan}\n";
    const PipelineResult installed = check(folder, over);
    REQUIRE(installed.pipeline.texts.size() == 3);
    CHECK(installed.pipeline.texts[1].file.string().ends_with("/share/fresco/pipelines/photo_texture.yaml"));
    CHECK(installed.pipeline.texts[2].file.string().ends_with("/share/fresco/pipelines/presets/preview.yaml"));
    // A file may extend the installed one of its own name.
    folder.write("photo_texture.yaml", over);
    const PipelineResult same =
        load_pipeline({.file = "photo_texture.yaml", .sets = {}, .working_directory = folder.path()}, usual_catalog());
    CHECK(same.pipeline.texts.size() == 3);
    folder.write("photo_texture.yaml", "version: 1\nstages: {own: {type: mesh.pass}}\n");
    const PipelineResult beside = check(folder, over);
    CHECK(names_of(beside) == Words{"own", "scan"});
    CHECK_THAT(joined_lines(check(folder, "version: 1\nbase: photo_textur.yaml\n")),
               StartsWith("p.yaml:2:7: error: no such pipeline file '" + folder.path().string() +
                          "/photo_textur.yaml', nor an installed one, '"));
}

TEST_CASE("A preview changes options of the pipeline and of its bases, and --set goes before it", "[pipeline]")
{
    const Room folder;
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
    const PipelineResult small = check(folder, text, usual_catalog(), {}, true);
    CHECK(options_of(small, "mesh") == R"({"max_faces":10,"keep_borders":true,"method":"edge"})");
    // Another type: the base's options are dropped, those of its preview too. A stage that is not there has none.
    CHECK(options_of(small, "frames") == R"({"title":"","size":1.0})");
    CHECK(names_of(small) == Words{"scan", "frames", "mesh", "uvmaps", "texture"});
    CHECK_THAT(options_of(small, "uvmaps"), StartsWith(R"({"heights_px":[99],)"));
    CHECK_THAT(options_of(small, "texture"), Contains(R"("epochs":1)") && Contains(R"("max_steps":7)"));
    CHECK_THAT(options_of(check(folder, text, usual_catalog(), {{"mesh.max_faces", "40"}}, true), "mesh"),
               StartsWith(R"({"max_faces":40,)"));
    CHECK(options_of(check(folder, text), "mesh") == R"({"max_faces":300,"keep_borders":true,"method":"quadric"})");
}

TEST_CASE("A preview that a pipeline lacks, or that does not fit it, is refused", "[pipeline]")
{
    const Room folder;
    const auto problems = [&](const std::string& text) { return lines(check(folder, text, usual_catalog(), {}, true)); };
    CHECK_THAT(problems(room).at(0), StartsWith("--preview: error: p.yaml has no 'preview': "));
    const auto bad = problems(room + "preview:\n  mesh: {type: mesh.pass}\n  mehs: {max_faces: 9}\n  frames: 3\n  uvmaps: "
                                     "{height: 3}\n  1a: {}\n");
    REQUIRE(bad.size() == 6);
    CHECK_THAT(bad[0], StartsWith("p.yaml:14:10: error: ") && Contains("type"));
    CHECK_THAT(bad[1], StartsWith("p.yaml:15:3: error: unknown stage 'mehs' (did you mean 'mesh'?)"));
    CHECK_THAT(bad[2], StartsWith("p.yaml:16:3: error: ") && Contains("must be a map"));
    CHECK_THAT(bad[3], StartsWith("p.yaml:17:12: error: ") && Contains("'height'"));
    CHECK_THAT(bad[4], StartsWith("p.yaml:18:3: error: '1a' cannot name a stage"));
    CHECK_THAT(joined_lines(check(folder, "version: 1\npreview: {mesh: {max_faces: 9}}\n")),
               StartsWith("p.yaml:1:1: error: missing stages"));
}

TEST_CASE("auto is the GPU only where the machine has one and the plugin was built for it")
{
    const auto settled = [](const char* device, bool for_gpu, bool has_gpu)
    {
        Value options = Value::Map{{"device", device}};
        settle_device(
            painter(for_gpu ? Value::Map{{"cuda", "12"}} : Value::Map{{"libtorch", "1.13"}}), options,
            has_gpu ? +[] { return true; } : +[] { return false; });
        return options.at("device").as_string();
    };
    CHECK(settled("auto", true, true) == "cuda");
    CHECK(settled("auto", true, false) == "cpu");
    CHECK(settled("auto", false, true) == "cpu");
    Catalog catalog;
    catalog.add(painter(Value::Map{}));
    catalog.add(stage("program", "", "", R"({"name": "gpu", "kind": "bool", "default": false, "device": true, "help": ""})"));
    const auto result = check({}, R"(version: 1
stages:
  usual: {type: paint}
  there: {type: paint, device: cuda}
  plain: {type: program}
  other: {type: program, gpu: true}
)",
                              catalog);
    CHECK(options_of(result, "usual") == R"({"device":"cpu"})");
    for (const char* name : {"usual", "there", "plain", "other"})
        CHECK(works_on_gpu(*result.pipeline.find(name)) == (name == std::string("there") || name == std::string("other")));
}

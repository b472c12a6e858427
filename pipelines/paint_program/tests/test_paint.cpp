#include "room_file.h"
#include "sheet.h"
#include "started_program.h"

#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/value.h>

#include <opencv2/imgcodecs.hpp>

using namespace fresco;
using namespace fresco::paint;

namespace
{

/// A folder in which the program runs, with a recording, a model and pictures that pass `fresco check`.
class Workplace
{
  public:
    Workplace()
    {
        fs::create_directories(file("my scan/seq-01"));
        write("chair.obj", "v 0 0 0\n");
        write("vgg.pth", "PK\3\4");
        for (const char* name : {"a.png", "it's b.png"})
            cv::imwrite(file(name), cv::Mat(40, 60, CV_8UC3, cv::Scalar(200, 100, 50)));
    }

    fs::path file(const std::string& name) const { return folder_.path() / name; }
    void write(const std::string& name, const std::string& text) const { write_file(file(name), text); }
    std::string read(const std::string& name) const { return read_text_file(file(name)); }
    Finished run(std::vector<std::string> words) const
    {
        words.insert(words.begin(), FRESCO_PAINT);
        return Background(words, {{"XDG_CACHE_HOME", file("cache")}}, folder_.path(), file("out.log"), file("err.log")).wait();
    }
    /// With nothing painted: the scan's folder has no frames, where the run ends with 3.
    Finished paint(std::vector<std::string> words) const
    {
        words.insert(words.begin(), "my scan");
        const Finished finished = run(words);
        CHECK(finished.code == 3);
        return finished;
    }
    Settings settings(const char* scan = "my scan") const { return {.scan = file(scan), .pictures = {file("a.png")}}; }
    /// Whether fresco finds no problem in it, as it is and as a preview.
    bool fits(const Settings& settings) const { return fits_text(pipeline_text(settings, kind_of(settings.scan))); }
    bool fits_text(const std::string& text) const
    {
        write("candidate.yaml", text);
        for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--preview"}})
        {
            std::vector<std::string> words{FRESCO_PROGRAM, "check", file("candidate.yaml")};
            words.insert(words.end(), more.begin(), more.end());
            const Finished finished = Background(words, {}, folder_.path(), file("out.log"), file("err.log")).wait();
            UNSCOPED_INFO(finished.out << finished.err << read("candidate.yaml"));
            if (finished.code != 0 || (finished.out + finished.err).find("no problems") == std::string::npos)
                return false;
        }
        return true;
    }

  private:
    testing::TemporaryFolder folder_;
};

std::string text_of(const Settings& settings)
{
    return pipeline_text(settings, kind_of(settings.scan));
}

}  // namespace

TEST_CASE("a scan is a recording, a model or splats, by its name and by a PLY file's header")
{
    const Workplace place;
    const auto kind = [&](const std::string& name, const std::string& text)
    {
        place.write(name, text);
        return kind_of(place.file(name));
    };
    CHECK(kind_of(place.file("my scan")) == ScanKind::recording);
    fs::create_directories(place.file("folder.glb"));
    CHECK(kind_of(place.file("folder.glb")) == ScanKind::recording);
    fs::create_directories(place.file("folder.splat"));
    CHECK(kind_of(place.file("folder.splat")) == ScanKind::recording);
    CHECK(kind("room.sens", "") == ScanKind::recording);
    CHECK(kind("room.GLB", "") == ScanKind::model);
    CHECK(kind("a.splat", "") == ScanKind::splats);
    const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n";
    CHECK(kind("mesh.ply", head + "end_header\n f_dc_0\n") == ScanKind::model);
    CHECK(kind("gauss.ply", head + "property float f_dc_0\nend_header\n") == ScanKind::splats);
    CHECK(kind("windows.ply", head + "property float f_dc_0\r\nend_header\r\n") == ScanKind::splats);
    CHECK(kind("packed.ply", head + "property uint packed_position\nend_header\n") == ScanKind::splats);
    CHECK(kind("gauss.glb", R"(glTF…{"extensionsUsed":["KHR_gaussian_splatting"]})") == ScanKind::splats);
    CHECK(kind("mesh.glb", "glTF") == ScanKind::model);
    CHECK(kind("gauss.gltf", R"({"extensionsUsed":["KHR_gaussian_splatting"]})") == ScanKind::splats);
    CHECK(kind("transforms.json", R"({"frames": []})") == ScanKind::recording);
    for (const auto& [name, text] :
         {std::pair{"sog/meta.json", R"({"version": 2, "means": {}})"}, {"lod/lod-meta.json", R"({"lodLevels": 3})"}})
    {
        const fs::path folder = fs::path(place.file(name)).parent_path();
        fs::create_directories(folder);
        CHECK(kind(name, text) == ScanKind::splats);
        CHECK(kind_of(folder) == ScanKind::splats);
    }
}

TEST_CASE("every setting is a line of the pipeline file, which fits the plugins")
{
    const Workplace place;
    Settings room = place.settings();
    CHECK(place.fits(room));
    CHECK(contains(text_of(room), "base: room.yaml"));
    CHECK(contains(text_of(room), "video: ~"));
    room.chosen =
        Value::Map{{"texture.stroke_cm", 6.5}, {"strength.color", 0.8}, {"strength.strokes", 0.8}, {"atlas.size_px", 4096}};
    CHECK(place.fits(room));
    CHECK(contains(text_of(room), "texture: {stroke_cm: 6.5}"));
    CHECK(contains(text_of(room), "atlas: {size_px: 4096}"));
    CHECK(contains(text_of(room), "color: 0.8, strokes: 0.8}"));
    room.chosen.set("keep", Value::List{"floor", "ceiling"});
    room.with = exports();
    CHECK(place.fits(room));
    CHECK(contains(text_of(room), "painted: mix}\n    regions: {floor: keep, ceiling: keep, \"*\": painted}"));
    CHECK(text_of(room).find("video") == std::string::npos);

    Settings large = place.settings();
    large.chosen.set("atlas.size_px", 8192);
    CHECK(place.fits(large));
    CHECK(contains(text_of(large), "base: large.yaml"));
    CHECK(contains(text_of(large), "bake: {size_px: 8192}"));
    large.pictures.push_back(place.file("it's b.png"));
    CHECK(place.fits(large));
    CHECK(contains(text_of(large), "preview:\n  atlas: {size_px: 768}\n  bake: {size_px: 768}\n"));

    Settings network = place.settings();
    network.weights = place.file("vgg.pth");
    network.chosen.set("strokes.stroke_cm", 4);
    network.with = exports();
    CHECK(place.fits(network));
    CHECK(contains(text_of(network), "strokes: {stroke_cm: 4}"));
    network.for_page = true;
    for (const Value::Map& chosen : {Value::Map{}, Value::Map{{"texture.epochs", 2}, {"relief.height_mm", 2}}})
    {
        network.chosen = chosen;
        CHECK(place.fits(network));
        const std::string text = stopped_at(text_of(network), 1200);
        network.chosen.set("texture.stop_at_step", 1200);
        CHECK(text_of(network) == text);
        CHECK(place.fits(network));
    }

    Settings model = place.settings("chair.obj");
    CHECK(place.fits(model));
    model.chosen = Value::Map{{"keep", Value::List{"floor"}}, {"atlas.size_px", 8192}};
    model.with = {"glb", "usdz", "obj", "ply", "page"};
    CHECK(place.fits(model));
    CHECK(contains(text_of(model), "type: export.gltf"));
    CHECK(text_of(model).find("room.obj") == std::string::npos);  // export.model writes it.
    CHECK(text_of(model).find("render.views") == std::string::npos);
    model.chosen = Value::Map{{"strength.color", 0.5}, {"up", "z"}, {"unit_m", 0.001}};
    model.pictures.push_back(place.file("it's b.png"));
    CHECK(place.fits(model));
    for (const char* part : {"\n  unit_m: 0.001\n  up: \"z\"\n", "views: {type: render.views, input: {mesh: bake}, up: \"${up}\"",
                             "preview:\n  atlas: {size_px: 768}\n  views: {height_px: 480}\n"})
        CHECK(contains(text_of(model), part));

    place.write("a.splat", std::string(32, '\1'));
    Settings splats = place.settings("a.splat");
    splats.chosen = Value::Map{{"keep", Value::List{"floor"}}, {"up", "-y"}, {"unit_m", 2}};
    splats.with = exports();
    CHECK(place.fits(splats));
    for (const char* part : {"base: splat.yaml", "{mesh: atlas, frames: scan}", "{mesh: bake, frames: scan}"})
        CHECK(contains(text_of(splats), part));

    // The studio adds stages for its page, exports and first looks.
    for (const char* scan : {"my scan", "chair.obj", "a.splat"})
    {
        Settings page = place.settings(scan);
        page.for_page = true;
        CHECK(place.fits(page));
        page.chosen = Value::Map{{"keep", Value::List{"floor"}},
                                 {"walls", place.file("it's b.png").string()},
                                 {"strength.color", 0.5},
                                 {"texture.stroke_cm", 6},
                                 {"relief.height_mm", 2}};
        CHECK(place.fits(page));
        const ScanKind kind = kind_of(page.scan);
        place.write("painting.yaml", text_of(page));
        const Value view =
            Value::Map{{"position_m", Value::List{0, 0, 1}}, {"forward", Value::List{1, 0, 0}}, {"up", Value::List{0, 0, 1}}};
        CHECK(place.fits_text(look_text(page, kind, view)));
        for (const std::string& name : exports())
            if (kind != ScanKind::model || (name != "video" && name != "views"))
                CHECK(place.fits_text(export_text(page, kind, name).first));
    }
    CHECK(export_text(model, ScanKind::model, "obj").second == "glb");
    CHECK(export_text(model, ScanKind::model, "glb").second == "taken");

    // Names that YAML, a var or a shell would take for something else.
    fs::create_directories(place.file("${data} \"x\": #/seq-01"));
    Settings odd = place.settings("${data} \"x\": #");
    CHECK(place.fits(odd));
    CHECK(shell_word("out/a-b_c.yaml") == "out/a-b_c.yaml");
    CHECK(shell_word("it's") == "'it'\\''s'");
    CHECK(shell_word("") == "''");
}

TEST_CASE("settings that do not go together are refused by name")
{
    const Workplace place;
    const auto refused = [](const Settings& settings, const std::string& words)
    { CHECK_THROWS_WITH(text_of(settings), Catch::Contains(words)); };
    Settings settings = place.settings();
    settings.chosen = Value::Map{{"atlas.size_px", 8192}, {"strength.color", 0.5}};
    refused(settings, "at most 4096");
    settings = place.settings();
    settings.weights = place.file("vgg.pth");
    settings.chosen.set("keep", Value::List{"floor"});
    refused(settings, "--stylemesh with --strength or --keep");
    settings = place.settings("chair.obj");
    settings.weights = place.file("vgg.pth");
    refused(settings, "a model or splats have none");
    settings = place.settings("chair.obj");
    settings.with = {"video"};
    refused(settings, "--with video: a model has no cameras");
    for (const Value::Map& chosen :
         {Value::Map{{"scan.path", "/etc"}}, Value::Map{{"texture.a b", 1}}, Value::Map{{"texture.seed", Value::List{}}},
          Value::Map{{"keep", Value::List{"a: b"}}}, Value::Map{{"strength.color", "1"}}})
    {
        settings = place.settings();
        settings.chosen = chosen;
        refused(settings, "not a setting");
    }
    CHECK_THROWS_WITH(export_text(place.settings(), ScanKind::recording, "exe"), Catch::Contains("expected glb"));
    place.write("a.spz", "");
    settings = place.settings("a.spz");
    settings.weights = place.file("vgg.pth");
    refused(settings, "a model or splats have none");
}

TEST_CASE("a pipeline file shows whether it was edited")
{
    const Workplace place;
    const std::string text = "version: 1\nstages:\n";
    const auto state = [&](const std::string& wanted) { return state_of(place.file("room.yaml"), wanted); };
    CHECK(state(text) == RoomState::replaceable);
    place.write("room.yaml", with_heading(text, "fresco run room.yaml"));
    CHECK(state(text) == RoomState::replaceable);
    CHECK(state("version: 2\n") == RoomState::replaceable);
    CHECK(state("version: 1\nvars:\n  data: \"other\"\n") == RoomState::other);
    place.write("room.yaml", "cores: 2\n" + place.read("room.yaml"));
    CHECK(state(text) == RoomState::edited);
    place.write("room.yaml", with_heading(text, "fresco run room.yaml") + "  texture: {seed: 2}\n");
    CHECK(state(text) == RoomState::edited);
    CHECK(state("version: 2\n") == RoomState::other);
    for (const char* others : {"", "version: 1\n", "# As written: 0"})
    {
        place.write("room.yaml", others);
        CHECK(state(text) == RoomState::other);
    }
}

TEST_CASE("a written pipeline file is written again, an edited one is used or refused")
{
    const Workplace place;
    const std::string path = "out/my scan-a/room.yaml";
    CHECK(contains(place.paint({"a.png"}).err, path + " written; again: "));
    CHECK(contains(place.read(path), "run 'out/my scan-a/room.yaml' --out 'out/my scan-a'"));
    place.paint({"a.png", "--stroke-cm", "6", "--set", "texture.seed=2", "--", "--cores", "1"});
    CHECK(contains(place.read(path), "stroke_cm: 6"));
    CHECK(contains(place.read(path), "--set texture.seed=2 --cores 1"));
    const std::string edited = place.read(path) + "  mesh: {max_faces: 1000}\n";
    place.write(path, edited);
    CHECK(contains(place.paint({"a.png", "--stroke-cm", "6"}).err, "room.yaml was edited and is used as it is; again: "));
    const Finished other = place.run({"my scan", "a.png"});
    CHECK(other.code == 2);
    CHECK(contains(other.err, "room.yaml: was edited, is for another scan, or fresco paint did not write it"));
    CHECK(contains(other.err, "choose another folder with --out, remove the file, or run it as it is: "));
    CHECK(place.read(path) == edited);
    fs::create_directories(place.file("mine"));
    place.write("mine/room.yaml", "version: 1\n");
    CHECK(contains(place.run({"my scan", "a.png", "--out", "mine"}).err, "fresco paint did not write it"));
    CHECK(place.read("mine/room.yaml") == "version: 1\n");
    place.paint({"a.png", "it's b.png"});
    CHECK(contains(place.read("out/my scan/room.yaml"), "matrix:"));
}

TEST_CASE("wrong inputs end before anything is written, and say what to do")
{
    const Workplace place;
    fs::create_directories(place.file("pictures only"));
    fs::create_directories(place.file("above/my scan"));
    fs::copy(place.file("a.png"), place.file("pictures only/1.png"));
    fs::copy(place.file("chair.obj"), place.file("above/chair.obj"));
    struct Case
    {
        std::vector<std::string> words;
        int code;
        std::vector<std::string> said;
    };
    const std::vector<Case> cases{
        {{}, 2, {"Usage: fresco paint"}},
        {{"my scan", "a.png", "--strokes", "2"}, 2, {"--help lists"}},
        {{"none", "a.png"}, 3, {"none: no such file or folder"}},
        {{"my scan"}, 2, {"name a picture to paint after", "sea_waves.jpg"}},
        {{"my scan", "none.png"}, 3, {"none.png: no such file"}},
        {{"my scan", "pictures only"}, 2, {"a folder; name the pictures to paint after: 'pictures only'/*.jpg"}},
        {{"my scan", "chair.obj"}, 2, {"no reader makes image from 'chair.obj'"}},
        {{"pictures only", "a.png"},
         3,
         {"no layout fits", "layout.tum looks for rgb.txt", "pictures only has 1 .png file\n", "COLMAP"}},
        {{"above", "a.png"}, 3, {"above has my scan/ and 1 .obj file\n", "name its file: ", "chair.obj"}},
        {{"my scan", "a.png", "--keep", "roof"}, 2, {"--keep: roof not in"}},
        {{"my scan", "a.png", "--with", "fbx"}, 2, {"--with: fbx not in"}},
        {{"my scan", "a.png", "--strength", "2"}, 2, {"--strength"}},
        {{"my scan", "a.png", "--set", "texture.stroke=2"}, 2, {"did you mean 'stroke_cm'"}},
        {{"my scan", "a.png", "--stylemesh"}, 2, {"--stylemesh needs --weights"}},
        {{"my scan", "a.png", "--weights", "vgg.pth"}, 2, {"--weights is for --stylemesh"}},
        {{"my scan", "a.png", "a.png"}, 2, {"a picture is named twice"}},
        {{"chair.obj", "a.png", "--with", "video"}, 2, {"a model has no cameras"}},
    };
    for (const Case& c : cases)
    {
        const Finished finished = place.run(c.words);
        INFO(Catch::StringMaker<std::vector<std::string>>::convert(c.words) << finished.out << finished.err);
        CHECK(finished.code == c.code);
        for (const std::string& words : c.said)
            CHECK(contains(finished.err + finished.out, words));
        CHECK(!fs::exists(place.file("out")));
    }
}

TEST_CASE("a signal that ends the program while it waits for a sheet ends the run, too")
{
    const Workplace place;
    place.write("wall.obj", "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nf 1 2 3 4\n");
    for (const char* name : {"a.png", "it's b.png"})
    {
        cv::Mat noise(256, 256, CV_8UC3);
        cv::randu(noise, 0, 255);
        cv::imwrite(place.file(name), noise);
    }
    Background painting({FRESCO_PAINT, "wall.obj", "a.png", "it's b.png", "--preview", "--size", "4096", "--stroke-cm", "0.5"},
                        {{"XDG_CACHE_HOME", place.file("cache")}}, place.file("."), place.file("out.log"), place.file("err.log"));
    const std::string events = "out/wall/preview/progress.jsonl";
    wait_until(
        [&]
        {
            const bool has_begun = fs::exists(place.file(events));
            return has_begun && place.read(events).find("\"begin\",\"stage\":\"texture") != std::string::npos;
        });
    const pid_t run = painting.a_child();
    painting.signal(SIGTERM);
    CHECK(painting.wait().code > 0);
    CHECK(kill(run, 0) != 0);
    CHECK_FALSE(contains(place.read(events), "\"summary\",\"exit_code\":0"));
    CHECK_FALSE(fs::exists(place.file("out/wall/preview/sheet.jpg")));
}

TEST_CASE("completion offers options and files")
{
    const Workplace place;
    CHECK(place.run({"internal-complete", "my scan", "--st"}).out == "--stroke-cm\n--strength\n--stylemesh\n");
    CHECK(place.run({"internal-complete", ""}).out == ":files\n");
    CHECK(contains(place.run({"--help-all"}).out, "Width of the brush strokes"));
}

TEST_CASE("a sheet joins the view that shows most, of each combination the same")
{
    const Workplace place;
    const auto view = [&](const std::string& name, int contrast, const cv::Scalar& tint)
    {
        cv::Mat picture(60, 80, CV_8UC4, tint);
        picture(cv::Rect(0, 0, 40, 60)).setTo(cv::Scalar(tint[0] - contrast, tint[1] - contrast, tint[2] - contrast, 255));
        fs::create_directories(place.file(name).parent_path());
        cv::imwrite(place.file(name), picture);
    };
    view("one/views/1.png", 20, {200, 0, 0, 255});
    view("one/views/2.png", 150, {0, 0, 250, 255});
    view("two/views/1.png", 60, {0, 200, 0, 255});
    view("two/views/2.png", 80, {0, 250, 0, 255});
    const auto cell = [](const char* name)
    {
        const std::string folder = name;
        return Value::Map{{"name", name},
                          {"stages", Value::List{"texture@" + folder}},
                          {"files", Value::List{folder + "/room.glb", folder + "/views/1.png", folder + "/views/2.png"}}};
    };
    const auto stage = [&](const char* name) {
        return Value::Map{{"name", name}, {"inputs", Value::List{Value::Map{{"file", place.file("a.png").string()}}}}};
    };
    place.write("sweep.json", to_json(Value::Map{{"combinations", Value::List{cell("one"), cell("two")}},
                                                 {"stages", Value::List{stage("texture@one"), stage("texture@two")}}}));
    const fs::path sheet = write_sheet(place.file("."));
    REQUIRE(fs::exists(sheet));
    const cv::Mat picture = cv::imread(sheet);
    REQUIRE(picture.cols == 2 * (640 + 12) + 12);
    const auto color = [&](int x) { return picture.at<cv::Vec3b>(200, x); };
    CHECK(color(12 + 500)[2] > 200);  // The second view of both, in their order.
    CHECK(color(12 + 652 + 500)[1] > 200);
    CHECK(std::abs(picture.at<cv::Vec3b>(picture.rows - 60, 40)[0] - 200) < 12);  // The style picture below.

    place.write("sweep.json", to_json(Value::Map{{"combinations", Value::List{}}, {"stages", Value::List{}}}));
    CHECK(write_sheet(place.file(".")).empty());
}

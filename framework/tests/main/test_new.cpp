#include "program.h"

#include "plugins/templates.h"

#include <fresco/error.h>

using namespace fresco::host;

namespace
{

/// Text of a file; empty: it is not there.
std::string text_of(const std::vector<TextFile>& files, const std::string& path)
{
    const auto file = std::ranges::find(files, path, &TextFile::path);
    return file != files.end() ? file->text : "";
}

/// The pictures that are installed beside the program of `place`.
void install_pictures(const Workplace& place)
{
    const fs::path pictures = place.root() / "share/fresco/pipelines/pictures";
    fs::create_directories(pictures);
    fresco::write_file(pictures / "unused.jpg", std::string("not copied"));
    fresco::write_file(pictures / "night_sky.jpg", std::string("not text: \xff\xd8\xff\0", 14));
}

}  // namespace

TEST_CASE("a new plugin has its own names everywhere, and names that no plugin can have are refused")
{
    for (const auto& kind : plugin_kinds())
    {
        CAPTURE(kind);
        const auto files = new_plugin(kind, "paint.dark_dots");
        for (const auto& file : files)
        {
            CAPTURE(file.path);
            CHECK_THAT(file.path + file.text, !Contains("my.plugin") && !Contains("my_plugin") && !Contains("MyPlugin"));
        }
        CHECK_THAT(text_of(files, "CMakeLists.txt"), Contains("fresco_add_plugin(paint_dark_dots\n"));
        const std::string part = kind == "stage" ? "stage" : "component";
        CHECK_THAT(text_of(files, part + ".cpp"), Contains("\"paint.dark_dots\", PaintDarkDots"));
        CHECK_THAT(text_of(files, "tests/test_" + part + ".cpp"), Contains("\"paint.dark_dots\""));
        // A layout is chosen by its marks.
        CHECK_THAT(text_of(files, "pipeline.yaml"),
                   Contains(kind == "layout" ? "type: scan.recording" : "type: paint.dark_dots"));
    }
    for (const std::string type :
         {"", "dots", "Paint.dots", "paint.", "paint..dots", "paint/../dots", "1paint.dots", "paint__a.dots"})
        CHECK_THROWS_AS(new_plugin("loss", type), fresco::Error);
}

TEST_CASE("fresco new writes a folder, whole or not at all, and never over one")
{
    Workplace place;
    CHECK_THAT(place.run({"new", "loss", "paint.dots"}, 1).err, Contains("share/fresco/pipelines/pictures is missing"));
    CHECK_FALSE(fs::exists(place.file("paint_dots")));
    install_pictures(place);
    CHECK_THAT(place.run({"new", "loss", "paint.dots"}, 0).out,
               Contains("paint_dots/component.cpp") && Contains("FRESCO_PLUGIN_PATH=paint_dots/build"));
    for (const auto& file : new_plugin("loss", "paint.dots"))
        CHECK(place.read("paint_dots/" + file.path) == file.text);
    CHECK(place.read("paint_dots/night_sky.jpg").size() == 14);

    place.write("paint_dots/component.cpp", "mine");
    CHECK_THAT(place.run({"new", "loss", "paint.dots"}, 2).err, Contains("paint_dots: already exists; nothing was written"));
    CHECK(place.read("paint_dots/component.cpp") == "mine");

    place.run({"new", "loss", "paint.lines", "--in", "a/b"}, 0);
    CHECK(fs::exists(place.file("a/b/paint_lines/component.cpp")));
    CHECK_THAT(place.run({"new", "stage", "test.add"}, 2).err, Contains("'test.add' already exists, in "));
    place.run({"new", "loss", "paint.more", "--in", "/proc"}, 1);  // Not even root can create a folder there.
    place.run({"new", "loss", "paint.more", "--in", "paint_dots/component.cpp"}, 1);
    for (const auto& entry : fs::recursive_directory_iterator(place.file(".")))
        CHECK_FALSE(contains(entry.path().string(), "fresco-new-"));
}

TEST_CASE("fresco init writes a project")
{
    Workplace place;
    install_pictures(place);
    CHECK_THAT(place.run({"schema"}, 3).err, Contains("pipeline.schema.json is missing: ./bootstrap build makes it"));
    place.run({"init", "without a schema"}, 0);
    CHECK_FALSE(contains(place.read("without a schema/pipeline.yaml"), "$schema="));
    fs::create_directories(place.root() / "share/fresco");
    fresco::write_file(place.root() / "share/fresco/pipeline.schema.json", std::string("{}"));
    CHECK_THAT(place.run({"init", "my room"}, 0).out, Contains("cd 'my room' && "));
    CHECK(place.read("my room/.gitignore") == ".fresco/\nout/\n");
    CHECK(place.read("my room/pipeline.yaml").starts_with("# yaml-language-server: $schema=" + place.run({"schema"}).out));
    fs::permissions(place.work(), fs::perms::all | fs::perms::sticky_bit);
    place.run({"init", "shared"}, 0);
    CHECK((fs::status(place.file("shared")).permissions() & (fs::perms::others_write | fs::perms::sticky_bit)) ==
          fs::perms::none);
    fs::create_directory(place.file("empty"));
    place.run({"init", "empty/"}, 0);
    CHECK(fs::exists(place.file("empty/pipeline.yaml")));
    place.run({"init", "."}, 2);
}

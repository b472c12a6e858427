#include "program.h"

#include "plugins/templates.h"

#include <fresco/error.h>

using Catch::Contains;
using namespace fresco::host;

namespace
{

const TextFile& file_of(const std::vector<TextFile>& files, const std::string& path)
{
    const auto file = std::ranges::find(files, path, &TextFile::path);
    REQUIRE(file != files.end());
    return *file;
}

/// The pictures that are installed beside the program of `place`.
void install_pictures(const Workplace& place)
{
    const fs::path pictures = place.root() / "share/fresco/pipelines/pictures";
    fs::create_directories(pictures);
    fresco::write_file(pictures / "unused.jpg", std::string("not copied"));
    fresco::write_file(pictures / "night_sky.jpg", std::string("not text: \xff\xd8\xff\0", 14));
}

std::ptrdiff_t files_below(const fs::path& folder)
{
    return std::ranges::count_if(fs::recursive_directory_iterator(folder),
                                 [](const auto& entry) { return entry.is_regular_file(); });
}

}  // namespace

TEST_CASE("a new plugin has its own names everywhere")
{
    for (const auto& kind : plugin_kinds())
    {
        CAPTURE(kind);
        const auto files = new_plugin(kind, "paint.dark_dots");
        CHECK(files.size() >= 5);
        for (const auto& file : files)
        {
            CAPTURE(file.path);
            for (const char* name : {"my.plugin", "my_plugin", "MyPlugin"})
                CHECK((file.path + file.text).find(name) == std::string::npos);
        }
        CHECK_THAT(file_of(files, "CMakeLists.txt").text, Contains("fresco_add_plugin(paint_dark_dots\n"));
        const std::string part = kind == "stage" ? "stage" : "component";
        CHECK_THAT(file_of(files, part + ".cpp").text, Contains("\"paint.dark_dots\", PaintDarkDots"));
        CHECK_THAT(file_of(files, "tests/test_" + part + ".cpp").text, Contains("\"paint.dark_dots\""));
        // A layout is chosen by its marks.
        CHECK_THAT(file_of(files, "pipeline.yaml").text,
                   Contains(kind == "layout" ? "type: scan.recording" : "type: paint.dark_dots"));
        CHECK_THAT(file_of(files, "README.md").text, Contains("# paint.dark_dots"));
    }
    CHECK(template_files("nothing").empty());
    CHECK_THAT(file_of(new_plugin("stage", "a.my_plugin"), "stage.cpp").text, Contains("\"a.my_plugin\", AMyPlugin"));
}

TEST_CASE("names that no plugin can have are refused")
{
    for (const char* type : {"", "dots", "Paint.dots", "paint dots", "paint.", ".dots", "paint..dots", "paint/../dots",
                             "1paint.dots", "_paint.dots", "paint__a.dots", "paint_.dots", "paint._dots"})
    {
        CAPTURE(type);
        CHECK_THROWS_AS(new_plugin("loss", type), fresco::Error);
    }
    CHECK_THROWS_WITH(new_plugin("project", "my.project2"), Contains("unknown kind of plugin 'project'"));
}

TEST_CASE("fresco new writes a folder, whole or not at all, and never over one")
{
    Workplace place;
    const auto missing = place.run({"new", "loss", "paint.dots"});
    CHECK(missing.code != 0);
    CHECK_THAT(missing.err, Contains("share/fresco/pipelines/pictures is missing"));
    CHECK_FALSE(fs::exists(place.file("paint_dots")));
    install_pictures(place);
    const auto made = place.run({"new", "loss", "paint.dots"});
    CAPTURE(made.err);
    REQUIRE(made.code == 0);
    CHECK_THAT(made.out, Contains("paint_dots/component.cpp") && Contains("FRESCO_PLUGIN_PATH=paint_dots/build"));
    CHECK(files_below(place.file("paint_dots")) == std::ssize(new_plugin("loss", "paint.dots")) + 1);
    CHECK(place.read("paint_dots/night_sky.jpg").size() == 14);

    place.write("paint_dots/component.cpp", "mine");
    const auto again = place.run({"new", "loss", "paint.dots"});
    CHECK(again.code == 2);
    CHECK_THAT(again.err, Contains("paint_dots: already exists; nothing was written"));
    CHECK(place.read("paint_dots/component.cpp") == "mine");

    CHECK(place.run({"new", "loss", "paint.lines", "--in", "a/b"}).code == 0);
    CHECK(fs::exists(place.file("a/b/paint_lines/component.cpp")));
    const auto known = place.run({"new", "stage", "test.add"});
    CHECK(known.code == 2);
    CHECK_THAT(known.err, Contains("'test.add' already exists, in "));
    CHECK(place.run({"new", "painting", "paint.other"}).code == 2);
    CHECK_THAT(place.run({"new", "loss", "dots"}).err, Contains("invalid type name 'dots'"));

    CHECK(place.run({"new", "loss", "paint.more", "--in", "/proc"}).code == 1);  // Not even root can create a folder there.
    CHECK(place.run({"new", "loss", "paint.more", "--in", "paint_dots/component.cpp"}).code == 1);
    for (const auto& entry : fs::recursive_directory_iterator(place.file(".")))
        CHECK_FALSE(contains(entry.path().string(), "fresco-new-"));
}

TEST_CASE("fresco init writes a project")
{
    Workplace place;
    install_pictures(place);
    const auto schema = place.run({"schema"});
    CHECK(schema.code == 3);
    CHECK_THAT(schema.err, Contains("pipeline.schema.json is missing: ./bootstrap build makes it"));
    REQUIRE(place.run({"init", "without a schema"}).code == 0);
    CHECK_FALSE(contains(place.read("without a schema/pipeline.yaml"), "$schema="));
    fs::create_directories(place.root() / "share/fresco");
    fresco::write_file(place.root() / "share/fresco/pipeline.schema.json", std::string("{}"));
    const auto made = place.run({"init", "my room"});
    CAPTURE(made.err);
    REQUIRE(made.code == 0);
    CHECK(place.read("my room/.gitignore") == ".fresco/\nout/\n");
    CHECK_THAT(place.read("my room/pipeline.yaml"), Contains("version: 1"));
    CHECK(place.read("my room/night_sky.jpg").size() == 14);
    CHECK(place.read("my room/pipeline.yaml").starts_with("# yaml-language-server: $schema=" + place.run({"schema"}).out));
    CHECK_THAT(made.out, Contains("cd 'my room' && "));
    fs::permissions(place.work(), fs::perms::all | fs::perms::sticky_bit);
    REQUIRE(place.run({"init", "shared"}).code == 0);
    CHECK((fs::status(place.file("shared")).permissions() & (fs::perms::others_write | fs::perms::sticky_bit)) ==
          fs::perms::none);
    CHECK(place.run({"init", "my room"}).code == 2);
    fs::create_directory(place.file("empty"));
    CHECK(place.run({"init", "empty/"}).code == 0);
    CHECK(fs::exists(place.file("empty/pipeline.yaml")));
    CHECK(place.run({"init", "."}).code == 2);
}

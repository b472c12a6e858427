#include "catch.h"
#include "hand_made_catalog.h"

#include "base/file_contents.h"
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>

using namespace fresco::host;
using namespace fresco::host::testing;
using Catch::EndsWith;
using namespace std::literals;

namespace
{

const std::string png_head = "\x89PNG\r\n\x1a\n" + std::string("\0\0\0\3IHDRabccrc1", 15);
const std::string png_end = std::string("\0\0\0\0IENDcrc2", 12);
const std::string jpeg_head = std::string("\xff\xd8\xff\xe1\0\4ab\xff\xda", 10) + "data";
const std::string glb = std::string("glTF\2\0\0\0\x10\0\0\0", 12) + "json";
const std::string weights = std::string("\2\0\0\0\0\0\0\0{}", 10);

const fresco::FileFormat json = fresco::json_format();
const std::vector<fresco::FileFormat> weights_formats{
    {.name = "a state dict", .extensions = {".pth"}, .begins = {"{"}, .begins_at = 8, .length_bytes = 8, .length_from = 8},
    {.name = "a state dict", .extensions = {".pth"}, .begins = {"PK\3\4", "\x80"}}};

std::vector<fresco::FileFormat> known_formats()
{
    std::vector<fresco::FileFormat> all = fresco::picture_formats();
    for (const auto& format :
         {fresco::npy_format(), fresco::ply_format(), fresco::obj_format(), json,
          fresco::FileFormat{.name = "a model", .extensions = {".glb"}, .begins = {"glTF"}, .length_at = 8, .length_bytes = 4},
          fresco::FileFormat{.name = "a recording", .extensions = {".sens"}, .begins = {"\4\0\0\0"s}}})
        all.push_back(format);
    all.insert(all.end(), weights_formats.begin(), weights_formats.end());
    return all;
}

struct Example
{
    std::string name;
    std::string text;
    std::string problem;  ///< Behind the file's name; empty: none.
};

}  // namespace

TEST_CASE("A file that does not match its name is recognized by its beginning and end", "[pipeline]")
{
    const std::string far(100'000, 'x');
    const std::vector<Example> examples{
        {"a.png", png_head + png_end, ""},
        {"a.png", png_head + png_end + "more", ""},
        {"A.PNG", jpeg_head + "\xff\xd9", ""},
        {"a.png", png_head, "is cut short: copy or export it again"},
        {"a.png", (png_head + png_end).substr(0, 28), "is cut short: copy or export it again"},
        {"a.png", png_head + "\xff\xff\xff\xffIDAT" + far, "is cut short: copy or export it again"},
        {"a.jpg", jpeg_head + "\xff\xd9" + far, ""},
        {"a.jpg", jpeg_head + far, "is cut short: copy or export it again"},
        {"a.jpg", jpeg_head.substr(0, 5), "is cut short: copy or export it again"},
        // The end lies across two pieces that are searched.
        {"a.jpg", jpeg_head + "\xff\xd9" + std::string(65535, 'x'), ""},
        {"a.jpg", "<!DOCTYPE html>\n<html>", "is not a PNG picture or a JPEG picture: it begins with \"<!DOCTYPE html>\""},
        {"a.jpg", "\x01\x02", "is not a PNG picture or a JPEG picture"},
        {"a.jpeg", ply_text, "is not a PNG picture or a JPEG picture: it is a PLY mesh"},
        {"a.jpeg", "", "is empty"},
        {"a.npy", "\x93NUMPY\1", ""},
        {"a.npy", jpeg_head, "is not an NPY file: it is a JPEG picture"},
        {"a.ply", ply_text, ""},
        {"a.ply", "ply\r\ncomment " + far + "\r\nend_header\r\n", ""},
        {"a.ply", "ply\nformat", "is cut short: copy or export it again"},
        {"a.ply", "this is a text about nothing in particular\n",
         "is not a PLY mesh: it begins with \"this is a text about nothing in …\""},
        {"a.obj", "# " + far + "\nv 0 0 0\n", ""},
        {"a.obj", "# hello\n", "is not an OBJ mesh: it begins with \"# hello\""},
        {"a.obj", "v 0 0 0\0"s, "is not an OBJ mesh: it begins with \"v 0 0 0\""},
        {"a.obj", "v 0 0 0\nf 1 1", "is cut short: copy or export it again"},
        {"a.glb", glb, ""},
        {"a.glb", glb.substr(0, 15), "is cut short: copy or export it again"},
        {"a.glb", "{}", "is not a model"},
        {"a.json", "\xef\xbb\xbf {\n}\n", ""},
        {"a.json", glb, "is not a JSON file: it is a model"},
        {"a.json", "{\"a\": [1, 2", "is cut short: copy or export it again"},
        {"a.sens", "\4\0\0\0"s, ""},
        {"a.sens", "\5\0\0\0"s, "is not a recording"},
        {"a.pth", weights, ""},
        {"a.pth", "PK\3\4", ""},
        {"a.pth", weights.substr(0, 9), "is cut short: copy or export it again"},
        {"a.pth", "version https://git-lfs", "is not a state dict: it begins with \"version https://git-lfs\""},
        {"a.other", "anything", ""},
        {"a.other", "", "is empty"},
    };
    const TemporaryFolder folder;
    for (const Example& example : examples)
    {
        CAPTURE(example.name, example.text.substr(0, 200));
        const auto file = folder.write(example.name, example.text);
        const std::string extension = example.name == "A.PNG" ? ".png" : file.extension().string();
        CHECK(file_problem(file, {extension}, known_formats(), known_formats) ==
              (example.problem.empty() ? "" : "'" + file.string() + "' " + example.problem));
    }
    CHECK_THAT(file_problem(folder.write("a.stl", "x"), {".ply", ".obj"}, {}, known_formats),
               EndsWith("' is a .stl file; expected .ply or .obj"));
    CHECK_THAT(file_problem(folder.write("a", "x"), {".ply"}, {}, known_formats), EndsWith("' has no extension; expected .ply"));
    // Others say what is wrong with these.
    CHECK(file_problem(folder.path(), {".ply"}, {}, known_formats).empty());
    CHECK(file_problem(folder.path() / "nothing", {".ply"}, {}, known_formats).empty());
}

TEST_CASE("Files of options and inputs are looked at when the pipeline is checked", "[pipeline]")
{
    Catalog catalog = hand_made_catalog();
    catalog.add(described("scan.file", "stage",
                          R"json({
        "options": [{"name": "path", "kind": "input_file", "required": true, "extensions": [".ply"], "help": "The mesh",
                     "formats": [)json" +
                              fresco::to_json(fresco::ply_format().describe()) + R"json(]}],
        "inputs": [], "outputs": [{"name": "mesh", "artifact": "mesh", "version": 1, "help": ""}]})json"));
    const TemporaryFolder folder;
    folder.write("room.ply", "hello\n");
    folder.write("good.ply", ply_text);
    folder.write("folder.ply/a", "");
    const auto problems = [&](const std::string& stage)
    {
        const auto result = check(folder, "version: 1\nstages:\n  a: " + stage + "\n", catalog);
        CHECK(result.exit_code() == (result.problems.empty() ? 0 : 3));
        return lines(result);
    };
    const std::string shown = "'" + (folder.path() / "room.ply").string() + "' is not a PLY mesh: it begins with \"hello\"";
    CHECK(problems("{type: scan.file, path: room.ply}") ==
          std::vector<std::string>{"p.yaml:3:30: error: stage 'a' (scan.file): option 'path': " + shown});
    CHECK(problems("{type: mesh.pass, input: {file: room.ply}}") ==
          std::vector<std::string>{"p.yaml:3:38: error: stage 'a' (mesh.pass): input 'mesh': " + shown});
    CHECK(problems("{type: scan.file, path: good.ply}").empty());
    CHECK(problems("{type: mesh.pass, input: {file: good.ply}}").empty());
    // Once, as what it is.
    const std::string is_folder = "'" + (folder.path() / "folder.ply").string() + "' is a folder, not a file";
    CHECK(problems("{type: scan.file, path: folder.ply}") ==
          std::vector<std::string>{"p.yaml:3:30: error: stage 'a' (scan.file): option 'path': " + is_folder});
    CHECK_THAT(problems("{type: scan.folder, path: good.ply}").at(0), EndsWith("good.ply' is not a folder"));
}

TEST_CASE("Folders of options are looked into when the pipeline is checked", "[pipeline]")
{
    Catalog catalog = hand_made_catalog();
    const auto add = [&](const std::string& type, const std::string& declaration)
    {
        catalog.add(described(type, "stage", R"({"inputs": [], "outputs": [], "options": [)" + declaration + R"(,
            {"name": "list", "kind": "input_file", "default": "", "help": "Another list"}]})"));
    };
    add("scan.frames", R"({"name": "path", "kind": "input_folder", "required": true, "help": "The scan",
                           "contains": ["seq-*/frame-?.png|all.mp4", "poses.txt"]})");
    add("scan.listed", R"({"name": "path", "kind": "input_folder", "default": "", "help": "The scan",
                           "contains": ["list.txt"], "contains_unless": "list"})");
    add("scan.posed",
        R"({"name": "path", "kind": "input_folder", "required": true, "help": "The scan", "contains": ["poses.*"]})");
    const TemporaryFolder folder;
    folder.write("good/seq-02/frame-1.png", "");
    folder.write("good/seq-01/notes.txt", "");
    folder.write("good/poses.txt", "");
    folder.write("video/all.mp4", "");
    folder.write("video/poses.txt", "");
    folder.write("posed/poses.json", "");
    folder.write("unpacked/scan/list.txt", "");
    folder.write("unpacked/list.md", "");
    const auto problems = [&](const std::string& type, const std::string& options)
    {
        const auto result = check(folder, "version: 1\nstages:\n  a: {type: " + type + ", " + options + "}\n", catalog);
        CHECK(result.exit_code() == (result.problems.empty() ? 0 : 3));
        return lines(result);
    };
    const auto problem = [&](const std::string& type, const std::string& path, const std::string& text)
    {
        return std::vector<std::string>{"p.yaml:3:" + std::to_string(21 + type.size()) + ": error: stage 'a' (" + type +
                                        "): option 'path': '" + (folder.path() / path).string() + "' does not contain " + text};
    };
    CHECK(problems("scan.frames", "path: good").empty());
    CHECK(problems("scan.frames", "path: video").empty());
    CHECK(problems("scan.frames", "path: unpacked") ==
          problem("scan.frames", "unpacked", "seq-*/frame-?.png, all.mp4 or poses.txt"));
    // Another stage reads it.
    CHECK(problems("scan.listed", "path: video") ==
          problem("scan.listed", "video", "list.txt; scan.frames or scan.posed read such a folder"));
    CHECK(problems("scan.frames", "path: posed") ==
          problem("scan.frames", "posed", "seq-*/frame-?.png, all.mp4 or poses.txt; scan.posed reads such a folder"));
    // One level off.
    const std::string meant = "list.txt; set it to '" + (folder.path() / "unpacked/scan").string() + "'";
    CHECK(problems("scan.listed", "path: unpacked") == problem("scan.listed", "unpacked", meant));
    CHECK(problems("scan.posed", "path: good/seq-01") ==
          problem("scan.posed", "good/seq-01", "poses.*; set it to '" + (folder.path() / "good").string() + "/'"));
    folder.write("unpacked/other/list.txt", "");
    CHECK(problems("scan.listed", "path: unpacked") == problem("scan.listed", "unpacked", "list.txt"));
    // Where the option says otherwise, and without a folder.
    CHECK(problems("scan.listed", "path: unpacked, list: good/poses.txt").empty());
    CHECK(problems("scan.listed", "path: ''").empty());
    CHECK_THAT(problems("scan.posed", "path: nowhere").at(0),
               EndsWith("no such folder '" + (folder.path() / "nowhere").string() + "'"));
}

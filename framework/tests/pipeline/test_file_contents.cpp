#include <catch2/catch.hpp>

#include "hand_made_catalog.h"

#include "base/file_contents.h"

using namespace fresco::host;
using namespace fresco::host::testing;
using Catch::Matchers::EndsWith;
using namespace std::literals;

namespace
{

const std::string png_head = "\x89PNG\r\n\x1a\n" + std::string("\0\0\0\3IHDRabccrc1", 15);
const std::string png_end = std::string("\0\0\0\0IENDcrc2", 12);
// A segment holds a small picture of its own, with its end.
const std::string jpeg_head = std::string("\xff\xd8\xff\xe1\0\6\xff\xd8\xff\xd9\xff\xda", 12) + "data";
const std::string glb = std::string("glTF\2\0\0\0\x10\0\0\0", 12) + "json";
const std::string weights = std::string("\2\0\0\0\0\0\0\0{}", 10);

struct Example
{
    std::string name;
    std::string text;
    std::string problem;  ///< Behind the file's name; empty: none.
};

}  // namespace

TEST_CASE("A file that is not what its name says is told from a good one by its beginning and end", "[pipeline]")
{
    const std::string far(100'000, 'x');
    const std::vector<Example> examples{
        {"a.png", png_head + png_end, ""},
        {"a.png", png_head + png_end + "more", ""},
        {"A.PNG", jpeg_head + "\xff\xd9", ""},
        {"a.png", png_head, "is cut short: copy or export it again"},
        {"a.png", (png_head + png_end).substr(0, 34), "is cut short: copy or export it again"},
        {"a.png", png_head + "\xff\xff\xff\xffIDAT" + far, "is cut short: copy or export it again"},
        {"a.jpg", jpeg_head + "\xff\xd9" + far, ""},
        {"a.jpg", jpeg_head + far, "is cut short: copy or export it again"},
        {"a.jpg", jpeg_head.substr(0, 5), "is cut short: copy or export it again"},
        // The end lies across two pieces that are searched.
        {"a.jpg", jpeg_head + "\xff\xd9" + std::string(65535, 'x'), ""},
        {"a.jpg", "<!DOCTYPE html>\n<html>", "is not a PNG or JPEG picture: it begins with \"<!DOCTYPE html>\""},
        {"a.jpg", "\x01\x02", "is not a PNG or JPEG picture"},
        {"a.jpeg", ply_text, "is not a PNG or JPEG picture: it is a PLY mesh"},
        {"a.jpeg", "", "is empty"},
        {"a.npy", "\x93NUMPY\1", ""},
        {"a.npy", jpeg_head, "is not an NPY file: it is a PNG or JPEG picture"},
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
        {"a.glb", "{}", "is not a GLB model"},
        {"a.gltf", "\xef\xbb\xbf {\n}\n", ""},
        {"a.gltf", glb, "is not a glTF model: it is a GLB model"},
        {"a.json", "{\"a\": [1, 2", "is cut short: copy or export it again"},
        {"a.sens", "\4\0\0\0"s, ""},
        {"a.sens", "\5\0\0\0"s, "is not a .sens recording of version 4"},
        {"a.safetensors", weights, ""},
        {"a.pth", "PK\3\4", ""},
        {"a.pth", weights.substr(0, 9), "is cut short: copy or export it again"},
        {"a.pt", "version https://git-lfs",
         "is not a safetensors file or a PyTorch state dict: it begins with \"version https://git-lfs\""},
        {"a.other", "anything", ""},
        {"a.other", "", "is empty"},
    };
    const TemporaryFolder folder;
    for (const Example& example : examples)
    {
        CAPTURE(example.name, example.text.substr(0, 200));
        const auto file = folder.write(example.name, example.text);
        const std::string extension = example.name == "A.PNG" ? ".png" : file.extension().string();
        CHECK(file_problem(file, {extension}) == (example.problem.empty() ? "" : "'" + file.string() + "' " + example.problem));
    }
    CHECK_THAT(file_problem(folder.write("a.stl", "x"), {".ply", ".obj"}), EndsWith("' is a .stl file; expected .ply or .obj"));
    CHECK_THAT(file_problem(folder.write("a", "x"), {".ply"}), EndsWith("' has no extension; expected .ply"));
    // Others say what is wrong with these.
    CHECK(file_problem(folder.path(), {".ply"}).empty());
    CHECK(file_problem(folder.path() / "nothing", {".ply"}).empty());
}

TEST_CASE("Files of options and inputs are looked at when the pipeline is checked", "[pipeline]")
{
    Catalog catalog = hand_made_catalog();
    catalog.add(described("scan.file", "stage", R"json({
        "options": [{"name": "path", "kind": "input_file", "required": true, "extensions": [".ply"], "help": "The mesh"}],
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

#include "catch.h"
#include "hand_made_catalog.h"

#include "base/file_contents.h"
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>

using namespace fresco::host;
using namespace fresco::host::testing;
using namespace std::literals;

namespace
{

const std::string png_head = "\x89PNG\r\n\x1a\n" + std::string("\0\0\0\3IHDRabccrc1", 15);
const std::string png_end = std::string("\0\0\0\0IENDcrc2", 12);
const std::string jpeg_head = std::string("\xff\xd8\xff\xe1\0\4ab\xff\xda", 10) + "data";
const std::string glb = std::string("glTF\2\0\0\0\x10\0\0\0", 12) + "json";
const std::string weights = std::string("\2\0\0\0\0\0\0\0{}", 10);

std::vector<fresco::FileFormat> known_formats()
{
    std::vector<fresco::FileFormat> all = fresco::picture_formats();
    all.insert(
        all.end(),
        {fresco::npy_format(),
         fresco::ply_format(),
         fresco::obj_format(),
         fresco::json_format(),
         {.name = "a model", .extensions = {".glb"}, .begins = {"glTF"}, .length_at = 8, .length_bytes = 4},
         {.name = "a state dict", .extensions = {".pth"}, .begins = {"{"}, .begins_at = 8, .length_bytes = 8, .length_from = 8},
         {.name = "a state dict", .extensions = {".pth"}, .begins = {"PK\3\4", "\x80"}}});
    return all;
}

const std::string pictures = "a PNG picture, a JPEG picture, a WebP picture or a HEIC or AVIF picture";
// 16 bytes each behind the first 12.
const std::string webp = std::string("RIFF\x14\0\0\0WEBP", 12) + std::string(16, 'x');
const std::string heic = std::string("\0\0\0\x10"
                                     "ftypheic",
                                     12) +
                         std::string(16, 'x');

}  // namespace

TEST_CASE("A file that does not match its name is recognized by its beginning and end", "[pipeline]")
{
    const std::string far(100'000, 'x');
    const TemporaryFolder folder;
    // The problem stands behind the file's name.
    for (const auto& [name, text, problem] : std::vector<std::array<std::string, 3>>{
             {"a.png", png_head + png_end, ""},
             {"a.png", png_head + png_end + "more", ""},
             {"A.PNG", jpeg_head + "\xff\xd9", ""},
             {"a.png", png_head, "is cut short: copy or export it again"},
             {"a.png", png_head + "\xff\xff\xff\xffIDAT" + far, "is cut short: copy or export it again"},
             {"a.jpg", jpeg_head + "\xff\xd9" + far, ""},
             {"a.jpg", jpeg_head + far, "is cut short: copy or export it again"},
             // The end lies across two pieces that are searched.
             {"a.jpg", jpeg_head + "\xff\xd9" + std::string(65535, 'x'), ""},
             {"a.jpg", "<!DOCTYPE html>\n<html>", "is not " + pictures},
             {"a.jpeg", "", "is empty"},
             {"a.jpg", webp, ""},
             {"a.webp", webp.substr(0, 27), "is cut short: copy or export it again"},
             {"a.avif", heic, ""},
             {"a.npy", jpeg_head, "is not an NPY file"},
             {"a.ply", "ply\r\ncomment " + far + "\r\nend_header\r\n", ""},
             {"a.ply", "ply\nformat", "is cut short: copy or export it again"},
             {"a.ply", "this is a text about nothing in particular\n", "is not a PLY mesh"},
             {"a.obj", "# " + far + "\nv 0 0 0\n", ""},
             {"a.obj", "v 0 0 0\0"s, "is not an OBJ mesh"},
             {"a.obj", "v 0 0 0\rv 1 0 0\r", ""},
             {"a.glb", glb, ""},
             {"a.glb", glb.substr(0, 15), "is cut short: copy or export it again"},
             {"a.json", "\xef\xbb\xbf {\n}\n", ""},
             {"a.json", "{\"a\": [1, 2", "is cut short: copy or export it again"},
             {"a.pth", weights, ""},
             {"a.pth", "PK\3\4", ""},
             {"a.pth", weights.substr(0, 9), "is cut short: copy or export it again"},
             {"a.pth", "version https://git-lfs", "is not a state dict"},
             {"a.other", "", "is empty"},
         })
    {
        CAPTURE(name, text.substr(0, 200));
        const auto file = folder.write(name, text);
        const std::string extension = name == "A.PNG" ? ".png" : file.extension().string();
        CHECK(file_problem(file, {extension}, known_formats()) == (problem.empty() ? "" : "'" + file.string() + "' " + problem));
    }
    CHECK_THAT(file_problem(folder.write("a.stl", "x"), {".ply", ".obj"}, {}),
               EndsWith("' is a .stl file; expected .ply or .obj"));
    CHECK_THAT(file_problem(folder.write("a", "x"), {".ply"}, {}), EndsWith("' has no extension; expected .ply"));
    for (const char* name : {"a.ktx2", "a.png"})
        CHECK_THAT(file_problem(folder.write(name, "\xabKTX 20\xbb\r\n"), {".png"}, known_formats()),
                   EndsWith("' is a KTX2 texture, which is not read: ktx extract --transcode rgba8 FILE.ktx2 FILE.png makes a "
                            "picture of it"));
}

TEST_CASE("Files of options and inputs are looked at when the pipeline is checked", "[pipeline]")
{
    Catalog catalog = hand_made_catalog();
    catalog.add(stage("scan.file", "", "mesh mesh",
                      R"json({"name": "path", "kind": "input_file", "required": true, "extensions": [".ply"], "help": "",
                              "formats": [)json" +
                          fresco::to_json(fresco::ply_format().describe()) + "]}"));
    catalog.add(stage("style.pass", "style image", ""));
    const TemporaryFolder folder;
    folder.write("a.ktx2", "\xabKTX 20\xbb\r\n");
    folder.write("room.ply", "hello\n");
    folder.write("good.ply", ply_text);
    folder.write("folder.ply/a", "");
    const std::string shown = "'" + (folder.path() / "room.ply").string() + "' is not a PLY mesh";
    const std::string is_folder = "'" + (folder.path() / "folder.ply").string() + "' is a folder, not a file";
    for (const auto& [stage, problem] : std::vector<std::pair<std::string, std::string>>{
             {"{type: mesh.pass, input: {file: good.ply}}", ""},
             {"{type: scan.file, path: room.ply}", "p.yaml:3:30: error: stage 'a' (scan.file): option 'path': " + shown},
             {"{type: mesh.pass, input: {file: room.ply}}", "p.yaml:3:38: error: stage 'a' (mesh.pass): input 'mesh': " + shown},
             {"{type: style.pass, input: {file: a.ktx2}}",
              "p.yaml:3:39: error: stage 'a' (style.pass): input 'style': 'a.ktx2' is " + fresco::picture_formats().back().name},
             // Once, as what it is.
             {"{type: scan.file, path: folder.ply}", "p.yaml:3:30: error: stage 'a' (scan.file): option 'path': " + is_folder}})
    {
        const auto result = check(folder, "version: 1\nstages:\n  a: " + stage + "\n", catalog);
        CHECK(result.exit_code() == (problem.empty() ? 0 : 3));
        CHECK(joined_lines(result) == problem);
    }
}

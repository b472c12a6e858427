#pragma once

#include "base/common.h"
#include "pipeline/pipeline.h"
#include "plugins/catalog.h"
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/plugin_library.h>
#include <fresco/testing.h>

#include <filesystem>
#include <fmt/ranges.h>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

/// \file A catalog without libraries, a pipeline of its types, and a folder for pipeline files that goes away with the test.

namespace fresco::host::testing
{

inline TypeDescription described(const std::string& type, const std::string& kind, const std::string& json,
                                 const std::vector<FileFormat>& formats = {})
{
    TypeDescription description;
    description.type = type;
    description.kind = kind;
    description.help = "What " + type + " does";
    description.declaration = parse_json(json, type);
    if (!formats.empty())
        description.declaration.set("formats", each<Value>(formats, &FileFormat::describe));
    description.library = "/plugins/" + type + ".so";
    return description;
}

/// "inputs" or "outputs" of a declaration, from "NAME ARTIFACT, …"; an input whose artifact ends with '?' is optional.
inline std::string ports(const std::string& list, const std::string& words)
{
    std::string text;
    std::istringstream stream(words);
    std::string name;
    for (std::string artifact; stream >> name >> artifact;)
    {
        const std::size_t end = artifact.find_first_of("?,");
        text += (text.empty() ? "" : ", ") + ("{\"name\": \"" + name) + "\", \"artifact\": \"" + artifact.substr(0, end) +
                "\", \"version\": 1, \"help\": \"\"" + (artifact.find('?') == std::string::npos ? "}" : ", \"optional\": true}");
    }
    return "\"" + list + "\": [" + text + "]";
}

inline TypeDescription stage(const std::string& type, const std::string& inputs, const std::string& outputs,
                             const std::string& options = "")
{
    return described(type, "stage",
                     "{\"options\": [" + options + "], " + ports("inputs", inputs) + ", " + ports("outputs", outputs) + "}");
}

/// The stages of a usual pipeline, two losses, feature networks, readers, and one of every kind of option.
inline Catalog hand_made_catalog()
{
    Catalog catalog;
    catalog.add(stage("scan.folder", "", "frames frames, mesh mesh", R"json(
        {"name": "path", "kind": "input_folder", "required": true, "help": "Folder of the scan"},
        {"name": "every", "kind": "int", "default": 1, "min": 1.0, "help": "Take one frame in so many"})json"));
    catalog.add(stage(
        "frames.sharpest", "frames frames", "kept frames",
        R"({"name": "min_sharpness", "kind": "number", "default": 100.0, "min": 0.0, "help": "Below this a frame is blurry"})"));
    catalog.add(stage("mesh.decimate", "mesh mesh", "simplified mesh", R"json(
        {"name": "max_faces", "kind": "int", "default": 500000, "min": 4.0, "max": 50000000.0,
         "help": "Stop at this many triangles"},
        {"name": "keep_borders", "kind": "bool", "default": true, "help": "Keep open borders"},
        {"name": "method", "kind": "text", "default": "quadric", "choices": ["quadric", "edge"], "help": "How"})json"));
    catalog.add(
        stage("atlas.flat", "mesh mesh", "atlas mesh", R"({"name": "size_px", "kind": "int", "default": 2048, "help": "Side"})"));
    catalog.add(stage("uvmaps.raster", "mesh mesh, frames frames", "maps uv_maps", R"json(
        {"name": "heights_px", "kind": "ints", "default": [256], "min": 16.0, "max": 4096.0, "help": "Heights"},
        {"name": "weights", "kind": "numbers", "default": [], "help": "Weights"})json"));
    catalog.add(stage("texture.optimize", "maps uv_maps, frames frames, style image, mask image?", "texture texture", R"json(
        {"name": "size_px", "kind": "int", "default": 2048, "min": 0.0, "max": 16384.0, "help": "Side"},
        {"name": "epochs", "kind": "int", "default": 2, "help": "Visits of every view"},
        {"name": "max_steps", "kind": "int", "default": 0, "help": "Last step"},
        {"name": "weights", "kind": "input_file", "default": "", "help": "Weights of VGG-19"},
        {"name": "preview", "kind": "output_name", "default": "", "in_key": false, "help": "Preview picture"},
        {"name": "losses", "kind": "components", "component_kind": "loss", "default": {"style": {"type": "loss.gram", "weight": 2.0}},
         "help": "Weighted losses"},
        {"name": "rule", "kind": "component", "component_kind": "rule", "help": "Optional rule"})json"));
    catalog.add(stage(
        "export.gltf", "texture texture", "files files",
        R"({"name": "path", "kind": "output_name", "default": "room.glb", "extensions": [".glb"], "help": "Name of the file"})"));
    catalog.add(stage("mesh.two", "", "left mesh, right mesh"));
    catalog.add(stage("mesh.pass", "mesh mesh?", "mesh mesh", R"json(
        {"name": "title", "kind": "text", "default": "", "help": "A text"},
        {"name": "size", "kind": "number", "default": 1.0, "help": "A number"})json"));
    catalog.add(stage("mesh.judged", "", "", R"json(
        {"name": "loss", "kind": "component", "component_kind": "loss", "default": {"type": "loss.content"}, "optional": true,
         "help": "May be left out"},
        {"name": "needed", "kind": "component", "component_kind": "loss", "default": {"type": "loss.content"}, "help": "May not"})json"));
    catalog.add(described("mesh.future", "stage", R"json({"options": [],
        "inputs": [{"name": "mesh", "artifact": "mesh", "version": 2, "help": ""}], "outputs": []})json"));
    const auto component = [&](const std::string& type, const std::string& kind, const std::string& options)
    { catalog.add(described(type, kind, "{\"inputs\": [], \"outputs\": [], \"options\": [" + options + "]}")); };
    component("loss.gram", "loss", R"({"name": "weight", "kind": "number", "default": 1.0, "min": 0.0, "help": "Weight"},
        {"name": "features", "kind": "component", "component_kind": "features", "default": {"type": "features.edges"}, "help": "Network"})");
    component("loss.content", "loss", R"({"name": "weight", "kind": "number", "default": 70.0, "min": 0.0, "help": "Weight"})");
    component("features.edges", "features", R"({"name": "seed", "kind": "int", "default": 1, "help": "Seed"})");
    component("features.vgg", "features", R"({"name": "weights", "kind": "input_file", "required": true, "help": "Weights"})");
    catalog.add(described("read.image", "reader", R"json({
        "options": [{"name": "max_px", "kind": "int", "default": 100, "help": "Largest side"}],
        "inputs": [], "outputs": [], "artifact": "image", "extensions": [".png", ".jpg"]})json",
                          picture_formats()));
    catalog.add(described("read.mesh", "reader", R"json({
        "options": [], "inputs": [], "outputs": [], "artifact": "mesh", "extensions": [".ply"]})json",
                          {ply_format()}));
    return catalog;
}

/// With a kind of component that pipelines choose, two of it, a stage that needs one, and one that can do without.
inline Catalog catalog_with_codecs()
{
    Catalog catalog = hand_made_catalog();
    const auto component = [&](const std::string& type, const std::string& options)
    { catalog.add(described(type, "codec", "{\"inputs\": [], \"outputs\": [], \"options\": [" + options + "]}")); };
    component("codec.plain", "");
    component("codec.fast", R"({"name": "level", "kind": "int", "default": 3, "min": 1.0, "help": "Effort"})");
    for (const std::string optional : {"", R"("optional": true, )"})
        catalog.add(described(optional.empty() ? "picture.write" : "picture.peek", "stage", R"({"options": [], "inputs": [],
            "outputs": [], "components": [{"name": "codec", "kind": "component", "component_kind": "codec",
                                           "default": {"type": "codec.plain"}, )" + optional + R"("help": "Encodes"}]})"));
    return catalog;
}

struct TemporaryFolder : fresco::testing::TemporaryFolder
{
    std::filesystem::path write(const std::string& name, const std::string& text) const
    {
        std::filesystem::create_directories((path() / name).parent_path());
        std::ofstream(path() / name, std::ios::binary) << text;
        return path() / name;
    }
};

/// Smallest valid files of these kinds.
inline const std::string jpeg_text("\xff\xd8\xff\xda\0\2\xff\xd9", 8);
inline const std::string ply_text = "ply\nend_header\n";

/// As long as the program, as a checked pipeline needs its catalog.
inline const Catalog& usual_catalog()
{
    static const Catalog catalog = hand_made_catalog();
    return catalog;
}

using Sets = std::vector<std::pair<std::string, std::string>>;
using Words = std::vector<std::string>;

/// Checks `text` as the file p.yaml in `folder`, which is also the working directory.
inline PipelineResult check(const TemporaryFolder& folder, const std::string& text, const Catalog& catalog = usual_catalog(),
                            const Sets& sets = {}, bool preview = false)
{
    folder.write("p.yaml", text);
    return load_pipeline({.file = "p.yaml", .sets = sets, .working_directory = folder.path(), .preview = preview}, catalog);
}

/// All problems as lines.
inline Words lines(const PipelineResult& result)
{
    return each(result.problems, [](const Problem& problem) { return to_string(problem); });
}

inline std::string joined_lines(const PipelineResult& result)
{
    return fmt::format("{}", fmt::join(lines(result), " | "));
}

inline Words names_of(const PipelineResult& result)
{
    return each(result.pipeline.stages, &PipelineStage::name);
}

/// Options of a stage, or all problems.
inline std::string options_of(const PipelineResult& result, const char* stage)
{
    const PipelineStage* found = result.pipeline.find(stage);
    return !result.problems.empty() ? joined_lines(result) : found ? fresco::to_json(*found->options) : "no stage";
}

inline const std::string room = R"(version: 1
vars: {data: scan, picture: pic.jpg, weights: ""}
stages:
  glb:     {type: export.gltf, input: texture, path: room.glb}
  scan:    {type: scan.folder, path: "${data}"}
  frames:  {type: frames.sharpest, input: scan, min_sharpness: 150}
  mesh:    {type: mesh.decimate,   input: scan, max_faces: 400000}
  uvmaps:  {type: uvmaps.raster,   input: {mesh: mesh, frames: frames}, heights_px: [256, 432]}
  texture:
    type: texture.optimize
    input: {maps: uvmaps, frames: frames, style: {file: "${picture}"}}
    weights: "${weights}"
)";

/// A folder with what pipelines such as `room` name.
struct Room : TemporaryFolder
{
    Room()
    {
        write("scan/a.png", "1");
        write("pic.jpg", jpeg_text);
        write("vgg.st", "1");
    }
};

}  // namespace fresco::host::testing

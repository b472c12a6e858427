#pragma once

#include "pipeline/pipeline.h"
#include "plugins/catalog.h"
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/texture.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

/// \file A catalog without libraries, and a folder for pipeline files that goes away with the test.

namespace fresco::host::testing
{

inline TypeDescription described(const std::string& type, const std::string& kind, const std::string& json, const Cost& cost = {})
{
    TypeDescription description;
    description.type = type;
    description.kind = kind;
    description.help = "What " + type + " does";
    description.declaration = parse_json(json, type);
    if (kind == "stage")
        description.declaration.set("cost", describe_cost(type, cost, description.declaration.at("options")));
    description.library = "/plugins/" + type + ".so";
    description.library_hash = "00";
    return description;
}

inline TypeDescription described(const std::string& type, const std::string& kind, const std::string& json,
                                 const std::vector<FileFormat>& formats)
{
    TypeDescription description = described(type, kind, json);
    Value::List all;
    for (const FileFormat& format : formats)
        all.push_back(format.describe());
    description.declaration.set("formats", std::move(all));
    return description;
}

/// The stages of a usual pipeline, two losses, feature networks, readers, and one of every kind of option.
inline Catalog hand_made_catalog()
{
    Catalog catalog;
    catalog.add(described("scan.folder", "stage", R"json({
        "options": [{"name": "path", "kind": "input_folder", "required": true, "help": "Folder of the scan"},
                    {"name": "every", "kind": "int", "default": 1, "min": 1.0, "help": "Take one frame in so many"}],
        "inputs": [],
        "outputs": [{"name": "frames", "artifact": "frames", "version": 1, "help": "Posed frames"},
                    {"name": "mesh", "artifact": "mesh", "version": 1, "help": "The scanned surface"}]})json",
                          {.seconds = {.fixed = 1, .per = {{count::frames, 0.01}}},
                           .memory_mb = {.fixed = 50},
                           .disk_mb = {.fixed = 1},
                           .makes = {{count::frames, {.files = "path", .pattern = "*.png", .divided_by = {"every"}}},
                                     {count::faces, {.files = "path", .pattern = "mesh.ply", .bytes_each = 10}}}}));
    catalog.add(described(
        "frames.sharpest", "stage", R"json({
        "options": [{"name": "min_sharpness", "kind": "number", "default": 100.0, "min": 0.0, "help": "Below this a frame is blurry"}],
        "inputs": [{"name": "frames", "artifact": "frames", "version": 1, "help": "Frames"}],
        "outputs": [{"name": "kept", "artifact": "frames", "version": 1, "help": "The sharp ones"}]})json",
        {.seconds = {.per = {{count::frames, 0.02}}}, .parallel_share = 1, .memory_mb = {.fixed = 20, .per_core = 10}}));
    catalog.add(described("mesh.decimate", "stage", R"json({
        "options": [{"name": "max_faces", "kind": "int", "default": 500000, "min": 4.0, "max": 50000000.0, "unit": "count",
                     "help": "Stop at this many triangles"},
                    {"name": "keep_borders", "kind": "bool", "default": true, "help": "Keep open borders"},
                    {"name": "method", "kind": "text", "default": "quadric", "choices": ["quadric", "edge"], "help": "How"}],
        "inputs": [{"name": "mesh", "artifact": "mesh", "version": 1, "help": "Mesh"}],
        "outputs": [{"name": "simplified", "artifact": "mesh", "version": 1, "help": "Fewer triangles"}]})json",
                          {.seconds = {.per = {{count::faces, 1e-6}}},
                           .memory_mb = {.fixed = 100, .per = {{count::faces, 1e-4}}},
                           .disk_mb = {.per = {{count::faces, 1e-4}}},
                           .makes = {{count::faces, {.at_most = "max_faces"}}}}));
    catalog.add(described("atlas.flat", "stage", R"json({
        "options": [{"name": "size_px", "kind": "int", "default": 2048, "unit": "px", "help": "Side"}],
        "inputs": [{"name": "mesh", "artifact": "mesh", "version": 1, "help": "Mesh"}],
        "outputs": [{"name": "atlas", "artifact": "mesh", "version": 1, "help": "Charts"}]})json",
                          {.makes = {{count::texels, {.squares_of = "size_px"}}}}));
    catalog.add(described("uvmaps.raycast", "stage", R"json({
        "options": [{"name": "heights_px", "kind": "ints", "default": [256], "min": 16.0, "max": 4096.0, "unit": "px", "help": "Heights"},
                    {"name": "weights", "kind": "numbers", "default": [], "help": "Weights"}],
        "inputs": [{"name": "mesh", "artifact": "mesh", "version": 1, "help": "Mesh"},
                   {"name": "frames", "artifact": "frames", "version": 1, "help": "Frames"}],
        "outputs": [{"name": "maps", "artifact": "uv_maps", "version": 1, "help": "Uv maps"}]})json",
                          {.seconds = {.per = {{count::pixels, 1e-6}}},
                           .memory_mb = {.per = {{count::pixels, 1e-3}}},
                           .disk_mb = {.per = {{count::frames, 1}}},
                           .makes = {{count::pixels, {.squares_of = "heights_px"}}}}));
    catalog.add(described("texture.optimize", "stage", R"json({
        "options": [{"name": "size_px", "kind": "int", "default": 2048, "min": 0.0, "max": 16384.0, "unit": "px", "help": "Side"},
                    {"name": "epochs", "kind": "int", "default": 2, "help": "Visits of every view"},
                    {"name": "max_steps", "kind": "int", "default": 0, "help": "Last step"},
                    {"name": "weights", "kind": "input_file", "default": "", "help": "Weights of VGG-19"},
                    {"name": "preview", "kind": "output_name", "default": "", "in_key": false, "help": "Preview picture"},
                    {"name": "losses", "kind": "components", "component_kind": "loss", "default": "auto",
                     "auto": {"option": "weights",
                              "if_empty": {"style": {"type": "loss.gram", "weight": 2.0}},
                              "if_set": {"style": {"type": "loss.gram", "features": {"type": "features.vgg", "weights": "${weights}"}},
                                         "content": {"type": "loss.content"}}},
                     "help": "Weighted losses"},
                    {"name": "rule", "kind": "component", "component_kind": "rule", "help": "Optional rule"}],
        "inputs": [{"name": "maps", "artifact": "uv_maps", "version": 1, "help": "Uv maps"},
                   {"name": "frames", "artifact": "frames", "version": 1, "help": "Frames"},
                   {"name": "style", "artifact": "image", "version": 1, "help": "The style picture"},
                   {"name": "mask", "artifact": "image", "version": 1, "optional": true, "help": "Where to paint"}],
        "outputs": [{"name": "texture", "artifact": "texture", "version": 1, "help": "The texture"}]})json",
                          {.seconds = {.fixed = 1, .per = {{count::pixels, 1e-6}}, .per_step = 1},
                           .memory_mb = {.per = {{count::texels, 1e-6}}},
                           .disk_mb = {.fixed = 1},
                           .makes = {{count::texels, {.squares_of = "size_px"}}},
                           .steps = {.brought = count::frames, .times = {"epochs"}, .at_most = "max_steps"}}));
    catalog.add(described("export.gltf", "stage", R"json({
        "options": [{"name": "path", "kind": "output_name", "default": "room.glb", "extensions": [".glb"], "help": "Name of the file"}],
        "inputs": [{"name": "texture", "artifact": "texture", "version": 1, "help": "The texture"}],
        "outputs": [{"name": "files", "artifact": "files", "version": 1, "help": "What was written"}]})json",
                          {.seconds = {.fixed = 1}, .memory_mb = {.per = {{count::texels, 1e-6}}}, .disk_mb = {.fixed = 5}}));
    catalog.add(described("mesh.two", "stage", R"json({"options": [], "inputs": [],
        "outputs": [{"name": "left", "artifact": "mesh", "version": 1, "help": ""}, {"name": "right", "artifact": "mesh", "version": 1, "help": ""}]})json"));
    catalog.add(described("mesh.pass", "stage", R"json({
        "options": [{"name": "title", "kind": "text", "default": "", "help": "A text"},
                    {"name": "size", "kind": "number", "default": 1.0, "help": "A number"}],
        "inputs": [{"name": "mesh", "artifact": "mesh", "version": 1, "optional": true, "help": ""}],
        "outputs": [{"name": "mesh", "artifact": "mesh", "version": 1, "help": ""}]})json"));
    catalog.add(described("mesh.judged", "stage", R"json({
        "options": [{"name": "loss", "kind": "component", "component_kind": "loss", "default": {"type": "loss.content"},
                     "optional": true, "help": "May be left out"},
                    {"name": "needed", "kind": "component", "component_kind": "loss", "default": {"type": "loss.content"},
                     "help": "May not"}],
        "inputs": [], "outputs": []})json"));
    catalog.add(described("mesh.future", "stage", R"json({"options": [],
        "inputs": [{"name": "mesh", "artifact": "mesh", "version": 2, "help": ""}], "outputs": []})json"));
    catalog.add(described("loss.gram", "loss", R"json({
        "options": [{"name": "weight", "kind": "number", "default": 1.0, "min": 0.0, "help": "Weight"},
                    {"name": "features", "kind": "component", "component_kind": "features",
                     "default": {"type": "features.edges"}, "help": "Feature network"}],
        "inputs": [], "outputs": []})json"));
    catalog.add(described("loss.content", "loss", R"json({
        "options": [{"name": "weight", "kind": "number", "default": 70.0, "min": 0.0, "help": "Weight"}],
        "inputs": [], "outputs": []})json"));
    catalog.add(described("features.edges", "features", R"json({
        "options": [{"name": "seed", "kind": "int", "default": 1, "help": "Seed"}], "inputs": [], "outputs": []})json"));
    catalog.add(described("features.vgg", "features", R"json({
        "options": [{"name": "weights", "kind": "input_file", "required": true, "help": "Weights"}], "inputs": [], "outputs": []})json"));
    catalog.add(described("read.image", "reader", R"json({
        "options": [{"name": "max_px", "kind": "int", "default": 100, "help": "Largest side"}],
        "inputs": [], "outputs": [], "artifact": "image", "extensions": [".png", ".jpg"]})json",
                          picture_formats()));
    catalog.add(described("read.mesh", "reader", R"json({
        "options": [], "inputs": [], "outputs": [], "artifact": "mesh", "extensions": [".ply"]})json",
                          {ply_format()}));
    return catalog;
}

class TemporaryFolder
{
  public:
    TemporaryFolder()
    {
        std::string pattern = (std::filesystem::temp_directory_path() / "fresco_test_XXXXXX").string();
        path_ = ::mkdtemp(pattern.data()) ? std::filesystem::canonical(pattern) : throw std::runtime_error("no temporary folder");
    }
    ~TemporaryFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path write(const std::string& name, const std::string& text) const
    {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << text;
        return path_ / name;
    }

  private:
    std::filesystem::path path_;
};

/// What files of these kinds must hold at least.
inline const std::string jpeg_text("\xff\xd8\xff\xda\0\2\xff\xd9", 8);
inline const std::string ply_text = "ply\nend_header\n";

using Sets = std::vector<std::pair<std::string, std::string>>;

/// Checks `text` as the file p.yaml in `folder`, which is also the working directory.
inline PipelineResult check(const TemporaryFolder& folder, const std::string& text, const Catalog& catalog, const Sets& sets = {})
{
    folder.write("p.yaml", text);
    return load_pipeline({"p.yaml", sets, folder.path()}, catalog);
}

/// All problems as lines.
inline std::vector<std::string> lines(const PipelineResult& result)
{
    std::vector<std::string> texts;
    for (const Problem& problem : result.problems)
        texts.push_back(to_string(problem));
    return texts;
}

}  // namespace fresco::host::testing

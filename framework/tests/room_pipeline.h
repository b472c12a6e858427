#pragma once

#include "hand_made_catalog.h"

/// \file A pipeline of the hand-made catalog's types, and the files that it names.

namespace fresco::host::testing
{

inline const std::string room = R"(version: 1
vars: {data: scan, picture: pic.jpg, weights: ""}
stages:
  glb:     {type: export.gltf, input: texture, path: room.glb}
  scan:    {type: scan.folder, path: "${data}"}
  frames:  {type: frames.sharpest, input: scan, min_sharpness: 150}
  mesh:    {type: mesh.decimate,   input: scan, max_faces: 400000}
  uvmaps:  {type: uvmaps.raycast,  input: {mesh: mesh, frames: frames}, heights_px: [256, 432]}
  texture:
    type: texture.optimize
    input: {maps: uvmaps, frames: frames, style: {file: "${picture}"}}
    weights: "${weights}"
)";

/// A folder with what the pipelines of these tests name.
struct Room : TemporaryFolder
{
    Room()
    {
        write("scan/a.png", "1");
        write("pic.jpg", jpeg_text);
        write("vgg.st", "1");
    }
};

inline std::string options_of(const PipelineResult& result, const char* stage)
{
    const PipelineStage* found = result.pipeline.find(stage);
    return found ? fresco::to_json(*found->options) : "no stage";
}

inline std::vector<std::string> names_of(const PipelineResult& result)
{
    std::vector<std::string> names;
    for (const PipelineStage& stage : result.pipeline.stages)
        names.push_back(stage.name);
    return names;
}

}  // namespace fresco::host::testing

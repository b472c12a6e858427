#pragma once

#include "scene_calibration.h"
#include "scene_folder.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>

namespace scannet
{

struct SceneFrames
{
    fresco::Frames frames;
    std::size_t not_tracked = 0;  ///< Views left out because their pose is not finite: the recorder had lost track.
};

/// Cameras and content hashes of the views, in their order. The pose file is world_from_depth; world_from_color =
/// world_from_depth * depth_from_color. All pictures of one camera have one size.
/// Throws Error naming the file: a pose that is no rigid transform, a picture of another size, intrinsics whose center is outside
/// the picture; Error if no view has a pose.
SceneFrames scene_frames(const std::vector<fresco::ViewFiles>& views, const SceneCalibration& calibration,
                         fresco::PixelCenter center, const fresco::ImageIo& images, fresco::Progress& progress);

/// Moves both to another world frame.
void transform_scene(const fresco::RigidTransform& new_from_old, fresco::Frames& frames, fresco::Mesh& mesh);

}  // namespace scannet

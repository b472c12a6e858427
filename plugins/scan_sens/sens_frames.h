#pragma once

#include "sens_file.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/progress.h>

#include <filesystem>

namespace sens
{

struct SensFrames
{
    fresco::Frames frames;
    std::size_t not_tracked = 0;  ///< Frames left out because their pose is not finite: the recorder had lost track.
};

/// Every `every`-th frame, from the first on, its pictures written into `folder`: frame-000000.color.jpg (JPEG as it is; raw ones
/// as PNG) and .depth.png. world_from_color = world_from_depth * inverse(depth's extrinsics) * color's extrinsics. Each thread
/// holds one frame. Throws Error naming file and byte for a picture that cannot be read, is cut or of another size, a pose that
/// is no rigid transform, intrinsics whose center is outside the picture; Error if no frame has a pose.
SensFrames extract_frames(const SensFile& file, const SensIndex& index, int every, const fresco::ImageIo& images,
                          const std::filesystem::path& folder, fresco::Progress& progress);

}  // namespace sens

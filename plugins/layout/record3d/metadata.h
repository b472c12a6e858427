#pragma once

#include <fresco/camera.h>

#include <optional>
#include <string_view>
#include <vector>

namespace record3d
{

struct Metadata
{
    int depth_width = 0;
    int depth_height = 0;
    std::vector<fresco::Intrinsics> cameras{};  ///< One for all pictures, or one for each.
    /// Per picture, with OpenCV's camera axes, in a world whose y points up; nothing where an entry is not finite.
    std::vector<std::optional<fresco::RigidTransform>> world_from_camera{};
};

/// Reads the file `metadata`, JSON: `w`, `h`, the size of the pictures; `dw`, `dh`, that of the depth pictures (without them,
/// that of the LiDAR scanner, 192 x 256 or 256 x 192); `K`, the matrix of intrinsics column by column, or
/// `perFrameIntrinsicCoeffs`, [fx, fy, cx, cy] of each picture; `poses`, [qx, qy, qz, qw, x, y, z] of each, world_from_camera
/// with OpenGL's camera axes, meters. Where the first pose is the identity, `initPose` says where it was in ARKit's world, y up.
/// Throws Error naming `source` and the key, also where all poses are the same: recordings by the front camera have none.
Metadata parse_metadata(std::string_view text, std::string_view source);

}  // namespace record3d

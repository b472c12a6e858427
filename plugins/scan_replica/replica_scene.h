#pragma once

#include <fresco/recordings/registered_view.h>

#include <filesystem>
#include <map>
#include <string_view>
#include <vector>

namespace replica
{

struct SceneCamera
{
    fresco::Intrinsics intrinsics;
    double depth_unit_m = 0;
};

/// The camera of cam_params.json: {"camera": {w, h, fx, fy, cx, cy, scale}}; the first pixel's center is at (0, 0) there, `scale`
/// is steps of depth per meter. Throws Error naming `source`, the key or byte.
SceneCamera parse_camera(std::string_view text, std::string_view source);

/// The poses of traj.txt: world_from_camera with OpenCV axes, 16 numbers row by row on each line. Throws Error "source:line: …",
/// also for a file that is cut.
std::vector<fresco::RigidTransform> parse_trajectory(std::string_view text, std::string_view source);

/// The pictures of one number in results.
struct PicturePair
{
    std::filesystem::path color;
    std::filesystem::path depth;
};

/// `folder`/frameN.jpg (or .png) and depthN.png by number. Throws MissingInput if there are none, Error for two of one number.
std::map<long, PicturePair> list_pictures(const std::filesystem::path& folder);

/// Views of every `every`-th pair. Frame N has the pose of line N + 1. Throws MissingInput that names missing partners, Error if
/// a frame has no line in `trajectory_file`.
std::vector<fresco::recordings::RegisteredView> scene_views(const std::map<long, PicturePair>& pictures,
                                                            const std::vector<fresco::RigidTransform>& trajectory,
                                                            const std::filesystem::path& trajectory_file,
                                                            const SceneCamera& camera, int every);

/// The first of `candidates` that is a file. Throws MissingInput that names them all and says `what` is missing.
std::filesystem::path first_file(const std::vector<std::filesystem::path>& candidates, std::string_view what);
/// Where the scene's camera and mesh are looked for, in this order.
std::vector<std::filesystem::path> camera_candidates(const std::filesystem::path& path);
std::vector<std::filesystem::path> mesh_candidates(const std::filesystem::path& path);

}  // namespace replica

#pragma once

#include <fresco/recordings/recorded_view.h>
#include <fresco/run_context.h>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace scannet
{

/// The properties of <scene>.txt, "key = value" per line. Throws Error "source:line: …" for a line without '=', a key twice, and
/// a camera's property in a last line that does not end.
std::map<std::string, std::string> parse_properties(std::string_view text, std::string_view source);

struct SceneCalibration
{
    fresco::recordings::CameraMatrix color;
    fresco::recordings::CameraMatrix depth;
    fresco::RigidTransform depth_from_color;
};

/// From `path`/intrinsic/{intrinsic_color, intrinsic_depth, extrinsic_color, extrinsic_depth}.txt where that folder is, else from
/// the properties fx_color, …, my_depth (both cameras then in one place: exported depth is registered to color). The extrinsics
/// map a camera's points to the recorder's: depth_from_color = inverse(extrinsic_depth) * extrinsic_color; a missing pair is the
/// identity. `properties` may be empty. Throws MissingInput if neither is there, Error naming file and line, or the property.
SceneCalibration read_scene_calibration(const std::filesystem::path& path, const std::filesystem::path& properties,
                                        fresco::RunContext& run);

}  // namespace scannet

#pragma once

#include <fresco/camera.h>
#include <fresco/recordings/lens.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace colmap
{

/// A camera of a reconstruction.
struct ModelCamera
{
    fresco::Intrinsics intrinsics;
    fresco::recordings::Lens lens;
    std::string source;  ///< Where it stands, for errors.
};

/// COLMAP's camera models that are read, with the names of their parameters in order.
struct CameraModel
{
    std::int32_t id;
    std::string_view name;
    std::vector<std::string_view> parameters;
    bool is_fisheye = false;
};

/// Throws Error naming `place` for a model that is unknown or not read, with what is.
const CameraModel& camera_model(std::string_view name, const std::string& place);
const CameraModel& camera_model(std::int32_t id, const std::string& place);

/// The camera of a model's parameters, in COLMAP's order. Throws Error naming `place` if the size is not 1 to 65536 pixels, the
/// count of parameters is another or one is not finite.
ModelCamera model_camera(const CameraModel& model, std::uint64_t width, std::uint64_t height,
                         const std::vector<double>& parameters, std::string place);

}  // namespace colmap

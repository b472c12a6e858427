#pragma once

#include <fresco/camera.h>
#include <fresco/value.h>

#include <string>
#include <string_view>

/// \file Pieces of the manifest, read strictly. What is not as expected is an Error that names the entry; the caller adds the
/// file.

namespace fresco::dataset::detail
{

/// {width, height, fx, fy, cx, cy, world_from_camera: three rows of four}
Value camera_value(const Camera& camera);
Camera camera_from(const Value& value, const std::string& name);

/// The same text, checked to be usable as one part of a path.
std::string checked_part(const std::string& text, const std::string& entry);
/// The same name, checked to lead to a file below the folder it is relative to.
std::string checked_name(const std::string& name);

}  // namespace fresco::dataset::detail

#pragma once

#include <fresco/dataset/manifest.h>

#include <cstddef>
#include <string>

inline constexpr const char* transforms_name = "transforms.json";

/// "images/000012.jpg": the picture of a view for other programs, with its extension.
std::string image_name(std::size_t view, const std::string& extension);
/// "depth/000012.png"
std::string depth_image_name(std::size_t view);

/// nerfstudio's transforms.json of all views, whose pictures must be among the manifest's files: pinhole intrinsics per frame,
/// poses with OpenGL camera axes, depth in millimeters in the color camera.
std::string transforms_text(const fresco::dataset::Manifest& manifest);

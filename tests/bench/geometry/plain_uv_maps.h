#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/uv_maps.h>

namespace bench
{

/// A uv map by testing every face for every pixel; what UvMapCaster must give, written without it. One thread.
fresco::UvMap plain_uv_map(const fresco::Mesh& mesh, const fresco::Camera& camera, int height_px);

}  // namespace bench

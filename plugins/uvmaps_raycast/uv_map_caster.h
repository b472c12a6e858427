#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>
#include <fresco/raycast/scene.h>
#include <fresco/uv_maps.h>

#include <cstdint>
#include <vector>

/// What became of a map's pixels; the four sum to width x height.
struct PixelCounts
{
    std::int64_t valid = 0;
    std::int64_t back_face = 0;
    std::int64_t too_near = 0;
    std::int64_t nothing = 0;

    PixelCounts& operator+=(const PixelCounts& other);
};

/// Casts the uv maps of one mesh: per pixel centre of a colour camera the texcoord (perspective-correct), the depth along the
/// optical axis (metres) and the cosine between the smooth vertex normal (area-weighted) and the direction to the camera.
class UvMapCaster
{
  public:
    /// The mesh needs texcoords, must have passed check_mesh and must outlive the caster.
    explicit UvMapCaster(const fresco::Mesh& mesh);

    /// The map of a camera at a height: width = Intrinsics::width_at, intrinsics scaled per axis. Rows are shared among
    /// progress.threads() threads in fixed blocks; the map does not depend on their number. Throws Cancelled.
    fresco::UvMap cast(const fresco::Camera& camera, int height_px, const fresco::Progress& progress, PixelCounts& counts) const;

  private:
    PixelCounts cast_rows(const fresco::Camera& camera, int first_row, int end_row, fresco::UvMap& map) const;

    fresco::raycast::Scene scene_;
    std::vector<fresco::Vec3f> vertex_normals_;
};

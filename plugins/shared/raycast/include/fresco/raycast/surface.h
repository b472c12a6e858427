#pragma once

#include <fresco/raycast/scene.h>
#include <fresco/uv_mapping/shading.h>

namespace fresco::raycast
{

using fresco::Sight;

/// Judges a hit of a ray whose length unit is a meter along the optical axis.
Sight sight(const Hit& hit);

std::array<Vec3d, 3> corners(const Mesh& mesh, std::uint32_t triangle);

/// The texcoord at a hit, perspective-correct.
Vec2d texcoord(const Mesh& mesh, const Hit& hit);
Vec2d texcoord(const Mesh& mesh, std::uint32_t triangle, const std::array<double, 3>& weights);

/// How many texels of a picture of width x height lie between a point on a triangle's plane and what the camera sees one pixel to
/// the right of it or below it, whichever is more: 0 where these do not meet the plane in front of the camera. `uv` is the
/// point's texcoord, (x, y) the pixel coordinates at which the camera sees it.
double texels_per_pixel(const Mesh& mesh, std::uint32_t triangle, Vec2d uv, const Camera& camera, double x, double y, int width,
                        int height);

/// The vertex normals (V) interpolated at a hit; unit length, zero where they cancel.
Vec3d normal(const Mesh& mesh, std::span<const Vec3f> vertex_normals, const Hit& hit);

}  // namespace fresco::raycast

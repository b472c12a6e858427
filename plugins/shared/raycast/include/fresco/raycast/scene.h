#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/uv_mapping/shading.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

/// \file Rays against a mesh by Embree, and what is at the place where one hits.

namespace fresco::raycast
{

/// First hit of a ray. The point is the sum of the triangle's corners times `weights` (they sum to 1, none is negative).
struct Hit
{
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    std::uint32_t triangle = none;
    bool front = false;             ///< The side from which the corners run counter-clockwise.
    double distance = 0;            ///< In lengths of the ray's direction.
    std::array<double, 3> weights;  ///< Indeterminate where nothing was hit.

    bool found() const { return triangle != none; }
};

/// A mesh prepared for rays (Embree, robust traversal: no ray slips through a shared edge, and such a ray belongs to exactly one
/// face). The search structure is built on one thread, so that equal meshes give equal hits for any thread count. Distances and
/// weights are computed in double precision from the mesh itself.
class Scene
{
  public:
    static constexpr int packet_size = 16;

    /// The mesh must have passed check_mesh and outlive the scene. Throws Error if Embree reports one (memory).
    explicit Scene(const Mesh& mesh);
    ~Scene();
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    /// The first hits of at most packet_size rays from one origin; `hits` is as long as `directions`. Thread-safe.
    void cast(Vec3d origin, std::span<const Vec3d> directions, std::span<Hit> hits) const;

    /// The hits of the pixel centers of rows [first_row, end_row) of a camera, row-major, (end_row - first_row) x width. With
    /// Camera::ray's directions a distance is the depth along the optical axis, meters. Thread-safe.
    void cast_rows(const Camera& camera, int first_row, int end_row, std::span<Hit> hits) const;

    const Mesh& mesh() const { return mesh_; }

  private:
    struct Embree;
    const Mesh& mesh_;
    std::unique_ptr<Embree> embree_;
};

/// Intersects the line origin + t * direction with the plane of a triangle: t, and weights that may be negative outside it. False
/// if the line runs along the plane or the triangle has no area.
bool meet_plane(const std::array<Vec3d, 3>& corners, Vec3d origin, Vec3d direction, double& distance,
                std::array<double, 3>& weights);

/// A literal such as "3.13.5"; enters the cache key of the stages that cast rays.
const char* embree_version();

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

}  // namespace fresco::raycast

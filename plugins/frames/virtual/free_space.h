#pragma once

#include <fresco/math.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

/// \file The places in a room where a virtual camera may stand. The stage plans its cameras there.

namespace fresco::virtual_views
{

struct FreeSpaceRules
{
    double voxel_m;      ///< Side of the voxels whose centers are tried.
    double clearance_m;  ///< From every surface.
};

/// The box around the mesh and the eyes, divided into voxels.
class VoxelGrid
{
  public:
    static constexpr double most_voxels = 4e6;

    /// Throws Error if the room is too small for a voxel and the clearance, or has too many voxels.
    VoxelGrid(const Mesh& mesh, std::span<const Vec3d> eyes, const FreeSpaceRules& rules);

    std::size_t count() const { return counts_[0] * counts_[1] * counts_[2]; }
    Vec3d center(std::size_t voxel) const;
    /// The voxels at most one step along each axis from the one that holds the point, itself included.
    std::vector<std::size_t> around(Vec3d point) const;
    /// The voxels that share a side with it.
    std::vector<std::size_t> beside(std::size_t voxel) const;

  private:
    std::array<std::size_t, 3> place(std::size_t voxel) const;
    std::size_t number(const std::array<std::size_t, 3>& place) const;

    Vec3d least_;
    double voxel_m_;
    std::array<std::size_t, 3> counts_{};
};

/// Centers of the voxels in which a camera may stand, in the grid's order. Each is connected to a recorded eye by straight steps
/// between centers that cross no surface, has no surface within clearance_m along 64 directions, and sees the backs of faces
/// along at most a quarter of the directions that end on a face; others lie behind walls or inside furniture. Throws Canceled.
std::vector<Vec3d> free_space(const raycast::Scene& scene, const VoxelGrid& grid, std::span<const Vec3d> eyes, double clearance_m,
                              const Progress& progress);

/// The first hits of any number of rays from one point; see Scene::cast.
std::vector<raycast::Hit> hits_from(const raycast::Scene& scene, Vec3d origin, std::span<const Vec3d> directions);

}  // namespace fresco::virtual_views

#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/splats/splats.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

/// \file Where the pictures of a splat are taken from: inside of a room or around an object. The stage renders them.

namespace scan_splats
{

/// The scene in voxels: where Gaussians block the view.
class OpacityGrid
{
  public:
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

    /// Throws Error if the splats have no extent.
    explicit OpacityGrid(const fresco::splats::Splats& splats);

    std::size_t count() const { return blocked_.size(); }
    double voxel_m() const { return voxel_m_; }
    fresco::Vec3d center(std::size_t voxel) const;
    /// `none` outside of the grid.
    std::size_t voxel_at(fresco::Vec3d point) const;
    bool blocked(std::size_t voxel) const { return blocked_[voxel] != 0; }
    /// Cells of 3 x 3 x 3 voxels, of which cameras are to see each.
    std::size_t cells_count() const { return gaussians_.size(); }
    std::uint32_t cell_of(std::size_t voxel) const;
    /// Centers of Gaussians in a cell.
    std::uint32_t gaussians(std::size_t cell) const { return gaussians_[cell]; }
    /// Whether nothing within `voxels` along each axis is blocked.
    bool clear(std::size_t voxel, int voxels) const;
    /// The first blocked voxel that a ray of unit direction meets, at least `from_m` away; `none` if it leaves the grid.
    std::size_t cast(fresco::Vec3d origin, fresco::Vec3d direction, double from_m) const;
    /// The ball around the blocked voxels.
    fresco::Vec3d middle() const { return middle_; }
    double radius_m() const { return radius_m_; }

  private:
    fresco::Vec3d low_, middle_;
    double voxel_m_ = 0, radius_m_ = 0;
    std::array<int, 3> counts_{};
    std::vector<std::uint8_t> blocked_;
    std::vector<std::uint32_t> gaussians_;
};

enum class Stand
{
    automatic,  ///< The choice that sees more of the Gaussians.
    inside,
    around
};

/// Places for cameras.
struct Places
{
    bool inside = false;
    std::vector<fresco::Vec3d> places;  ///< Inside: enclosed free space; around: two balls about the scene.
    double inside_share = 0;            ///< The share of Gaussians that is seen from enclosed free space.
    double around_share = 0;            ///< The share that is seen from around.
};

/// Throws Error if `stand` is inside and nothing is enclosed.
Places find_places(const OpacityGrid& grid, Stand stand, const fresco::Progress& progress);

/// Gaussians, at most some hundred thousand of them, as squares that face the free space: evidence of which way is up.
fresco::Mesh facing_squares(const fresco::splats::Splats& splats, const OpacityGrid& grid, bool inside,
                            const fresco::Progress& progress);

struct CameraPlan
{
    std::vector<fresco::Camera> cameras;
    double nearest_m = 0;   ///< Between a camera and what it shows.
    double seen_share = 0;  ///< Share of the cells that any candidate sees.
};

/// Level cameras, few of which see everything that can be seen from the places, and most of it from several sides.
CameraPlan plan_cameras(const OpacityGrid& grid, const Places& places, fresco::Vec3d up, const fresco::Progress& progress);

}  // namespace scan_splats

#pragma once

#include "surface_points.h"

#include <fresco/frames.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace fresco::virtual_views
{

/// Which points views paint: those that one of them sees, and those around them in the same chart.
class Coverage
{
  public:
    /// \param gap  how many cells of the grid, along each axis, paint spreads beyond what is seen
    Coverage(const raycast::Scene& scene, std::span<const SurfacePoint> points, int cells_px, int gap);

    /// A view more, without what its mask ignores (see load_mask): the numbers of the points that it sees and no earlier view
    /// painted, ascending. Throws Canceled.
    std::vector<std::uint32_t> add(const Camera& camera, const Raster8& mask, const Progress& progress);

    bool painted(std::uint32_t point) const { return painted_[point] != 0; }
    /// Ascending.
    std::vector<std::uint32_t> unpainted() const;

    const raycast::Scene& scene() const { return scene_; }
    std::span<const SurfacePoint> points() const { return points_; }

  private:
    void paint_around(std::uint32_t point);

    const raycast::Scene& scene_;
    std::span<const SurfacePoint> points_;
    int cells_px_;
    int gap_;
    std::vector<std::uint32_t> point_in_;  ///< Per cell: its point or nobody.
    std::vector<std::uint8_t> painted_;    ///< Per point.
};

inline constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

/// Adds the frames' color cameras. The median distance from which they see points first; 0 where they see none. Throws Canceled.
double add_frames(Coverage& coverage, const Frames& frames, Progress& progress);

/// For each of the points `asked` (ascending) one of the places that sees it (its number), or nobody. Throws Canceled.
std::vector<std::uint32_t> witnesses(const raycast::Scene& scene, std::span<const SurfacePoint> points,
                                     std::span<const Vec3d> places, std::span<const std::uint32_t> asked,
                                     const Progress& progress);

}  // namespace fresco::virtual_views

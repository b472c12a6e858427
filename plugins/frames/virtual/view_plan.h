#pragma once

#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/image.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>
#include <fresco/run_context.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

/// \file Plans the virtual cameras of the stage: points of the surface on a grid over the texture, the points that recorded and
/// planned views paint (Coverage), and the greedy choice of cameras (plan_views). Cameras stand in the free space of
/// free_space.h.

namespace fresco::virtual_views
{

/// The surface at one cell of the grid over the texture.
struct SurfacePoint
{
    Vec3f position;
    Vec3f normal;  ///< Normal of the face, unit length; zero if the face has no area, so that it is never seen.
    std::uint32_t face = 0;
    std::uint32_t chart = 0;
    std::uint32_t cell = 0;  ///< Row by row.
};

/// The points of all cells of a cells_px x cells_px grid whose center lies in a chart, row by row. The mesh needs texcoords.
std::vector<SurfacePoint> surface_points(const Mesh& mesh, int cells_px, const Progress& progress);

/// The points among `asked` that the eye sees, in their order: they face it, are at least nearest_surface_m away, and are not
/// occluded by a surface more than a millimeter before them. Thread-safe.
std::vector<std::uint32_t> visible_points(const raycast::Scene& scene, std::span<const SurfacePoint> points, Vec3d eye,
                                          std::span<const std::uint32_t> asked);

/// The points that views paint: those that at least one view sees, and those around them in the same chart.
class Coverage
{
  public:
    /// \param gap  cells of the grid, along each axis, that paint spreads beyond the seen ones
    Coverage(const raycast::Scene& scene, std::span<const SurfacePoint> points, int cells_px, int gap);

    /// Adds a view, without the pixels that its mask ignores (see load_mask). Returns the numbers of the points that it sees and
    /// that were unpainted, ascending. Throws Canceled.
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

/// Adds the frames' color cameras. Returns the median distance at which points are seen first; 0 if none is. Throws Canceled.
double add_frames(Coverage& coverage, const Frames& frames, Progress& progress);

/// Per point: the number of a place that sees it; nobody where none does, and for points that are not among those `asked`
/// (ascending). Throws Canceled.
std::vector<std::uint32_t> witnesses(const raycast::Scene& scene, std::span<const SurfacePoint> points,
                                     std::span<const Vec3d> places, std::span<const std::uint32_t> asked,
                                     const Progress& progress);

/// The orientation of pictures: that of the recorded ones, so that strokes run alike in all views.
struct Upright
{
    Vec3d up;               ///< World, unit length.
    int quarter_turns = 0;  ///< Clockwise turns of the picture that bring up to its top.
};
Upright upright_of(const Frames& frames, Vec3d up);

/// A camera at `eye` that looks along `forward` (unit length) without roll.
Camera level_camera(const Intrinsics& intrinsics, Vec3d eye, Vec3d forward, const Upright& upright);

struct PlanRules
{
    Intrinsics intrinsics;
    Upright upright;
    double distance_m;  ///< The best distance.
    std::size_t most_unpainted;
    std::size_t most_views;
};

struct ViewPlan
{
    std::vector<Camera> cameras;
    std::vector<std::uint32_t> unpainted;  ///< The remaining points of those wanted.
};

/// Chooses cameras at some of the places that together paint all points `wanted` but most_unpainted. Greedy: each camera is the
/// one that adds most to the sum of every point's best value. Works in rounds: candidates look in all directions and are tried on
/// a sample of the points; the best are kept and tried on all points; unpainted points go to the next round. Every round paints
/// at least one point: the witness of a sampled point is always among the places, and a round that paints none aims a camera at a
/// point. Adds the cameras to `coverage`. `witness_of`: per point, a place that sees it; every wanted one has one. Throws
/// Canceled.
ViewPlan plan_views(Coverage& coverage, std::span<const Vec3d> places, std::vector<std::uint32_t> wanted,
                    const std::vector<std::uint32_t>& witness_of, const PlanRules& rules, Progress& progress);

struct VirtualFrames
{
    double target_coverage = 0.9;  ///< Share to paint of the surface that free space reaches and recorded frames do not paint.
    int max_frames = 0;            ///< 0: as many as the target needs.
    double voxel_m = 0.2;          ///< Cameras may stand in the centers of such voxels: a few in every free square meter.
    double clearance_m = 0.5;      ///< Nearer to a surface, a texture's texels show as speckle.
    int cells_px = 1024;           ///< Cells along a side of the grid over the texture: centimeters in a room.
    int gap_px = 4;                ///< Texels that the coarse layers of a texture spread paint beyond what views see.
};

/// The recorded frames, then virtual ones of the sequence "virtual", which have no pictures; reports figures. Throws Error,
/// Canceled.
Frames with_virtual_frames(const Mesh& mesh, const Frames& recorded, const VirtualFrames& settings, RunContext& run);

}  // namespace fresco::virtual_views

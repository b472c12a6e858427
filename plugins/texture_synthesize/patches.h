#pragma once

#include "surface_grid.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fresco::synthesize
{

/// A square that lies on the surface: its points are in the plane of its frame, one texel apart.
struct Patch
{
    Vec3f center;
    TangentFrame frame;
    std::uint32_t texel = 0;  ///< At its center.
};

/// A patch over a texel, and where the texel lies on it.
struct Cover
{
    std::uint32_t patch = 0;
    std::int16_t x = 0;  ///< To the right of the patch's center, in 1 / 1024 texel.
    std::int16_t y = 0;  ///< Down.

    static constexpr float unit = 1024;
    Vec2f offset() const { return {static_cast<float>(x) / unit, static_cast<float>(y) / unit}; }
};

/// Patches all over a surface, each on a plane of its own. A patch reaches over the faces that join its center through edges and
/// whose smoothed normals are within 50 degrees of its own: across the atlas's seams, but not around corners, and never to what
/// merely lies behind it. So no chart's border shows.
class Patches
{
  public:
    /// Patches of `side` x `side` points (odd, at most 31) on every `stride`-th texel of each chart's grid both ways, and
    /// wherever a texel would have no patch's center within `stride` texels. Tops are up (see frame_at), or, with `lines` (one
    /// per face, unit length), x axes run along these, turned by at most a right angle. The same for any number of threads.
    /// Throws Canceled.
    Patches(const PaintedSurface& surface, const SurfaceGrid& grid, const Upright& upright, int side, int stride,
            const Progress& progress, std::span<const Vec3f> lines = {});

    int side() const { return side_; }
    std::size_t count() const { return patches_.size(); }
    const Patch& operator[](std::size_t patch) const { return patches_[patch]; }

    /// The patches over a texel, in ascending order; at least one.
    std::span<const Cover> covers(std::size_t texel) const
    {
        return std::span(covers_).subspan(first_cover_[texel], first_cover_[texel + 1] - first_cover_[texel]);
    }

    /// What `values` (one per texel) come to at a patch's points, row by row from the top left: side² of them, bilinear between
    /// texels. A point off the surface takes the value of the patch's nearest point on it.
    void sample(const SurfaceGrid& grid, std::span<const Vec3f> values, std::size_t patch, Vec3f* out) const;

  private:
    /// Where a patch's point lies between four cells of a chart's grid.
    struct Point
    {
        std::uint32_t cell = 0;   ///< The first of the four.
        std::uint16_t width = 0;  ///< From there to the cell below.
        std::uint8_t across = 0;  ///< In 1 / 256 cell.
        std::uint8_t along = 0;
    };
    class Walker;

    std::size_t points_per_patch() const { return static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_); }

    int side_;
    std::vector<Patch> patches_;
    std::vector<Point> points_;
    std::vector<std::size_t> first_cover_;
    std::vector<Cover> covers_;
};

}  // namespace fresco::synthesize

#pragma once

#include "painted_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

/// \file Divides a surface into texels of one size in meters, and covers it with overlapping square patches of such texels. The
/// synthesis looks every patch up in the picture; a texel gets its color from the patches over it.

namespace fresco::synthesize
{

/// Returns freed memory to the system. A synthesis frees hundreds of megabytes at a time, which malloc would keep.
void give_back_memory();

/// A surface in texels of one size in meters. Every chart of the atlas has its own grid, aligned with its texcoords; each point
/// of the surface belongs to one texel, independent of the size of the atlas's texture and of the packing of its charts.
class SurfaceGrid
{
  public:
    static constexpr std::uint32_t none = 0xffffffffU;

    struct Texel
    {
        Vec3f position;          ///< Meters.
        std::uint32_t face = 0;  ///< The face that holds its center.
        std::uint32_t cell = 0;
    };

    /// One chart's grid: its cells are first_cell + y * width + x. A margin of one cell lies around the chart.
    struct Sheet
    {
        std::size_t first_cell = 0;
        int width = 0;
        int height = 0;
        Vec2d uv_low;  ///< The chart's least texcoords.
        double cells_per_uv = 0;

        std::size_t cell(int x, int y) const
        {
            return first_cell + static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
        }
        int column(double x) const { return std::clamp(static_cast<int>(std::floor(x)), 0, width - 1); }
        int row(double y) const { return std::clamp(static_cast<int>(std::floor(y)), 0, height - 1); }
    };

    /// `spacing_m`: a texel's side. Charts without area have no texels. With `wanted` (1 or 0 per face), only wanted faces have
    /// texels, but for one in each chart. Throws Error for more than 2^32 cells, Canceled.
    SurfaceGrid(const PaintedSurface& surface, double spacing_m, const Progress& progress,
                std::span<const std::uint8_t> wanted = {});

    double spacing_m() const { return spacing_m_; }
    /// In the order of their cells: what is near in a chart is near in memory, whatever the order of the faces.
    const std::vector<Texel>& texels() const { return texels_; }
    std::span<const std::uint32_t> texels_of(std::size_t face) const
    {
        return std::span(of_face_).subspan(first_of_face_[face], first_of_face_[face + 1] - first_of_face_[face]);
    }
    /// Frees what only texels_of() needs, four bytes a texel.
    void forget_faces() { of_face_ = std::vector<std::uint32_t>(); }
    const Sheet& sheet(std::uint32_t chart) const { return sheets_[chart]; }
    bool has_sheet(std::uint32_t chart) const { return sheets_[chart].width > 0; }

    /// A texcoord of a chart in its grid, in cells; cell centers at +0.5.
    Vec2d place(std::uint32_t chart, Vec2f uv) const
    {
        const Sheet& s = sheets_[chart];
        return {(double{uv.x} - s.uv_low.x) * s.cells_per_uv + 1, (double{uv.y} - s.uv_low.y) * s.cells_per_uv + 1};
    }

    /// The texel of a cell; for a cell outside of the chart, the nearest texel in its grid.
    std::uint32_t texel_at(std::size_t cell) const { return texel_of_cell_[cell]; }

  private:
    void lay_out(const PaintedSurface& surface);
    void draw_face(const PaintedSurface& surface, std::uint32_t face, std::vector<Texel>& out) const;
    void adopt(const PaintedSurface& surface, std::uint32_t chart, std::uint32_t largest_face);
    void sort_by_cells(std::size_t faces);
    void extend(const Sheet& sheet);

    double spacing_m_;
    std::vector<Sheet> sheets_;
    std::vector<Texel> texels_;
    std::vector<std::uint32_t> of_face_;        ///< Texels of each face, one face after another.
    std::vector<std::uint32_t> first_of_face_;  ///< Per face its first place there, and an end.
    std::vector<std::uint32_t> texel_of_cell_;
};

/// A square that lies on the surface: its points are in the plane of its frame, one texel apart.
struct Patch
{
    Vec3f center;
    TangentFrame frame;
    std::uint32_t texel = 0;  ///< At its center.

    /// A point's place on the plane in meters, from the center to the right and down.
    Vec2f place(Vec3f point) const
    {
        const Vec3f away = point - center;
        return {dot(away, frame.right), dot(away, frame.down)};
    }
};

/// Patches all over a surface, each on its own plane. A patch covers the faces that are connected to its center through edges
/// under it and whose smoothed normals are within 50 degrees of its own: across the atlas's seams, so that no border of a chart
/// shows, but not around corners or onto surfaces behind it.
class Patches
{
  public:
    /// Lays patches of `side` x `side` points (odd, at most 31) on every `stride`-th texel of each chart's grid in both
    /// directions, and wherever a texel would have no center of a patch within `stride` texels. Their tops are up (see frame_at).
    /// With `lines` (one per face, unit length), their x axes run along the lines, turned by at most a right angle. With `share`
    /// (one per texel), only on texels where it is above 0. The same for any number of threads. Throws Canceled.
    Patches(const PaintedSurface& surface, const SurfaceGrid& grid, const Upright& upright, int side, int stride,
            const Progress& progress, std::span<const Vec3f> lines = {}, std::span<const float> share = {});

    int side() const { return side_; }
    std::size_t count() const { return patches_.size(); }
    const Patch& operator[](std::size_t patch) const { return patches_[patch]; }

    /// The patches over a texel, in ascending order; at least one where there is a share.
    std::span<const std::uint32_t> covers(std::size_t texel) const
    {
        return {&covers_[first_cover_[texel]], first_cover_[texel + 1] - first_cover_[texel]};
    }

    /// Position on a patch of a texel at `position`, in texels from its center to the right and down, to 1 / 1024. Not kept for
    /// every cover: that would double their memory.
    Vec2f offset(std::size_t patch, Vec3f position) const
    {
        const Vec2f at = patches_[patch].place(position);
        return {rounded(at.x * per_m_), rounded(at.y * per_m_)};
    }

    /// Samples `values` (one per texel) at a patch's points, row by row from the top left: side² results, bilinear between
    /// texels. A point off the surface takes the value of the patch's nearest point on it.
    void sample(const SurfaceGrid& grid, std::span<const Vec3f> values, std::size_t patch, Vec3f* out) const;
    /// Per texel: 1 if sample() reads its value.
    std::vector<std::uint8_t> sampled(const SurfaceGrid& grid, const Progress& progress) const;
    /// Frees what sample() needs, half of the memory.
    void forget_points() { points_ = {}; }

  private:
    /// A patch's point between four cells of a chart's grid.
    struct Point
    {
        std::uint32_t cell;   ///< The first of the four.
        std::uint16_t width;  ///< From there to the cell below.
        std::uint8_t across;  ///< In 1 / 256 cell.
        std::uint8_t along;
    };
    class Walker;

    /// The points of some patches, one word each where they lie in one grid around the patch's center, as most do; they are the
    /// largest part of what a synthesis holds.
    class PackedPoints
    {
      public:
        /// Adds the next patch, whose center is in `cell`.
        void add(std::span<const Point> points, std::uint32_t cell);
        /// Calls visit(point) for each point of a patch, in their order.
        template <class Visit>
        void visit(std::size_t patch, std::uint32_t cell, const Visit& visit) const;
        void reserve(std::size_t words) { words_.reserve(words); }
        void shrink() { words_.shrink_to_fit(); }

      private:
        std::vector<std::uint32_t> words_;  ///< For each patch: the width of its grid, or 0 if points have two words; the points.
        std::vector<std::size_t> first_;    ///< Word of each patch.
    };

    template <class Visit>
    void visit_points(const SurfaceGrid& grid, std::size_t patch, const Visit& visit) const;
    std::size_t points_per_patch() const { return static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_); }

    /// To 1 / 1024. As std::lround does, but inline.
    static float rounded(float texels)
    {
        constexpr float unit = 1024;
        return static_cast<float>(static_cast<int>(texels * unit + std::copysign(0.5F, texels))) / unit;
    }

    int side_;
    float per_m_;  ///< Texels.
    std::vector<Patch> patches_;
    std::size_t regular_ = 0;           ///< Patches on the stride's texels, the first ones.
    std::vector<PackedPoints> points_;  ///< Lists of equal length for the regular patches, and one for the rest.
    std::vector<std::size_t> first_cover_;
    std::unique_ptr<std::uint32_t[]> covers_;
};

}  // namespace fresco::synthesize

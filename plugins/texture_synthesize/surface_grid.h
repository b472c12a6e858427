#pragma once

#include "painted_surface.h"

#include <cstdint>
#include <vector>

namespace fresco::synthesize
{

/// A surface in texels of one size in the world. Every chart of the atlas has a grid of its own, laid in its texcoords; each
/// point of the surface belongs to one texel, whatever size the atlas's texture has and however charts are turned or packed in
/// it.
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
    };

    /// `spacing_m`: a texel's side. Charts without area have no texels. Throws Error for more than 2^32 cells, Canceled.
    SurfaceGrid(const PaintedSurface& surface, double spacing_m, const Progress& progress);

    double spacing_m() const { return spacing_m_; }
    const std::vector<Texel>& texels() const { return texels_; }
    const Sheet& sheet(std::uint32_t chart) const { return sheets_[chart]; }
    bool has_sheet(std::uint32_t chart) const { return sheets_[chart].width > 0; }

    /// Where a texcoord of a chart lies in its grid, in cells; cell centers at +0.5.
    Vec2d place(std::uint32_t chart, Vec2f uv) const
    {
        const Sheet& s = sheets_[chart];
        return {(double{uv.x} - s.uv_low.x) * s.cells_per_uv + 1, (double{uv.y} - s.uv_low.y) * s.cells_per_uv + 1};
    }

    /// The texel of a cell; of a cell outside of the chart the nearest in its grid.
    std::uint32_t texel_at(std::size_t cell) const { return texel_of_cell_[cell]; }
    /// The cell lies inside the chart: no other cell has its texel.
    bool owns(std::size_t cell) const { return texels_[texel_of_cell_[cell]].cell == cell; }

  private:
    void lay_out(const PaintedSurface& surface);
    void draw_face(const PaintedSurface& surface, std::uint32_t face);
    void adopt(const PaintedSurface& surface, std::uint32_t chart, std::uint32_t largest_face);
    void extend(const Sheet& sheet);

    double spacing_m_;
    std::vector<Sheet> sheets_;
    std::vector<Texel> texels_;
    std::vector<std::uint32_t> texel_of_cell_;
};

}  // namespace fresco::synthesize

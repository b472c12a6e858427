#include "surface_grid.h"

#include <fresco/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string>

namespace fresco::synthesize
{
namespace
{

/// Barycentric coordinates of `p`; clamped to the triangle where it lies outside by rounding.
std::array<double, 3> weights_at(const std::array<Vec2d, 3>& c, Vec2d p)
{
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    std::array<double, 3> w{cross(c[1] - p, c[2] - p) / area, cross(c[2] - p, c[0] - p) / area, cross(c[0] - p, c[1] - p) / area};
    double sum = 0;
    for (double& v : w)
        sum += v = std::max(v, 0.0);
    for (double& v : w)
        v /= sum;
    return w;
}

bool inside(const std::array<Vec2d, 3>& c, double area, Vec2d p)
{
    const double sign = area < 0 ? -1 : 1;
    for (std::size_t i = 0; i < 3; ++i)
        if (sign * cross(c[(i + 1) % 3] - c[i], p - c[i]) < 0)
            return false;
    return true;
}

Vec3f point_in(const Mesh& mesh, std::uint32_t face, const std::array<double, 3>& weights)
{
    Vec3d point;
    for (std::size_t i = 0; i < 3; ++i)
        point += vec_cast<double>(mesh.positions[mesh.triangles[face][i]]) * weights[i];
    return vec_cast<float>(point);
}

}  // namespace

SurfaceGrid::SurfaceGrid(const PaintedSurface& surface, double spacing_m, const Progress& progress) : spacing_m_(spacing_m)
{
    lay_out(surface);
    const auto faces = static_cast<std::uint32_t>(surface.mesh.triangles.size());
    for (std::uint32_t face = 0; face < faces; ++face)
    {
        if (face % 4096 == 0)
            progress.check_canceled();
        draw_face(surface, face);
    }

    std::vector<std::uint32_t> largest(sheets_.size(), none);
    std::vector<double> area(sheets_.size(), 0.0);
    std::vector<std::uint8_t> has_texel(sheets_.size(), 0);
    for (const Texel& texel : texels_)
        has_texel[surface.charts.of_face[texel.face]] = 1;
    for (std::uint32_t face = 0; face < faces; ++face)
    {
        const std::uint32_t chart = surface.charts.of_face[face];
        const double a = length(geometry::area_vector(surface.mesh, face));
        if (a > area[chart])
        {
            area[chart] = a;
            largest[chart] = face;
        }
    }
    for (std::uint32_t chart = 0; chart < sheets_.size(); ++chart)
        if (has_sheet(chart))
        {
            if (!has_texel[chart])
                adopt(surface, chart, largest[chart]);
            extend(sheets_[chart]);
        }
}

void SurfaceGrid::lay_out(const PaintedSurface& surface)
{
    const std::uint32_t charts = surface.charts.count;
    constexpr double huge = 1e30;
    std::vector<Vec2d> low(charts, {huge, huge});
    std::vector<Vec2d> high(charts, {-huge, -huge});
    for (std::size_t corner = 0; corner < surface.mesh.texcoords.size(); ++corner)
    {
        const std::uint32_t chart = surface.charts.of_face[corner / 3];
        const Vec2f uv = surface.mesh.texcoords[corner];
        low[chart] = {std::min(low[chart].x, double{uv.x}), std::min(low[chart].y, double{uv.y})};
        high[chart] = {std::max(high[chart].x, double{uv.x}), std::max(high[chart].y, double{uv.y})};
    }
    sheets_.resize(charts);
    std::size_t cells = 0;
    for (std::uint32_t c = 0; c < charts; ++c)
    {
        if (!(surface.uv_per_m[c] > 0))
            continue;
        Sheet& sheet = sheets_[c];
        sheet.uv_low = low[c];
        sheet.cells_per_uv = 1 / (surface.uv_per_m[c] * spacing_m_);
        const double width = std::ceil((high[c].x - low[c].x) * sheet.cells_per_uv) + 2;
        const double height = std::ceil((high[c].y - low[c].y) * sheet.cells_per_uv) + 2;
        if (static_cast<double>(cells) + width * height >= 4e9)
            throw Error(
                fmt::format("the surface has more than four billion texels of {:.3g} mm: use a larger stroke_cm, or check "
                            "that the mesh is in meters",
                            spacing_m_ * 1000));
        if (width > 65535)
            throw Error(
                fmt::format("a chart of the surface is {:.3g} m wide, more than 65535 texels of {:.3g} mm: check that the mesh "
                            "is in meters, or use a larger stroke_cm",
                            width * spacing_m_, spacing_m_ * 1000));
        sheet.width = static_cast<int>(width);
        sheet.height = static_cast<int>(height);
        sheet.first_cell = cells;
        cells += static_cast<std::size_t>(sheet.width) * static_cast<std::size_t>(sheet.height);
    }
    texel_of_cell_.assign(cells, none);
}

void SurfaceGrid::draw_face(const PaintedSurface& surface, std::uint32_t face)
{
    const std::uint32_t chart = surface.charts.of_face[face];
    if (!has_sheet(chart))
        return;
    const Sheet& sheet = sheets_[chart];
    std::array<Vec2d, 3> c;
    for (std::size_t i = 0; i < 3; ++i)
        c[i] = place(chart, surface.mesh.texcoords[3 * std::size_t{face} + i]);
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    if (area == 0)
        return;
    const auto [x0, x1] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [y0, y1] = std::minmax({c[0].y, c[1].y, c[2].y});
    const auto cell = [](double at, int count) { return std::clamp(static_cast<int>(std::floor(at)), 0, count - 1); };
    for (int y = cell(y0, sheet.height); y <= cell(y1, sheet.height); ++y)
        for (int x = cell(x0, sheet.width); x <= cell(x1, sheet.width); ++x)
        {
            const std::size_t at = sheet.first_cell + static_cast<std::size_t>(y) * static_cast<std::size_t>(sheet.width) +
                                   static_cast<std::size_t>(x);
            const Vec2d center{x + 0.5, y + 0.5};
            if (texel_of_cell_[at] != none || !inside(c, area, center))
                continue;
            texel_of_cell_[at] = static_cast<std::uint32_t>(texels_.size());
            texels_.push_back({point_in(surface.mesh, face, weights_at(c, center)), face, static_cast<std::uint32_t>(at)});
        }
}

void SurfaceGrid::adopt(const PaintedSurface& surface, std::uint32_t chart, std::uint32_t largest_face)
{
    constexpr std::array<double, 3> middle{1.0 / 3, 1.0 / 3, 1.0 / 3};
    const Sheet& sheet = sheets_[chart];
    Vec2d at;
    for (std::size_t i = 0; i < 3; ++i)
        at = at + place(chart, surface.mesh.texcoords[3 * std::size_t{largest_face} + i]) * middle[i];
    const int x = std::clamp(static_cast<int>(at.x), 0, sheet.width - 1);
    const int y = std::clamp(static_cast<int>(at.y), 0, sheet.height - 1);
    const auto cell = static_cast<std::uint32_t>(
        sheet.first_cell + static_cast<std::size_t>(y) * static_cast<std::size_t>(sheet.width) + static_cast<std::size_t>(x));
    texel_of_cell_[cell] = static_cast<std::uint32_t>(texels_.size());
    texels_.push_back({point_in(surface.mesh, largest_face, middle), largest_face, cell});
}

/// Cells outside of the chart take the texel of the nearest one inside, ring by ring.
void SurfaceGrid::extend(const Sheet& sheet)
{
    const auto width = static_cast<std::size_t>(sheet.width);
    std::vector<std::size_t> ring;
    std::vector<std::size_t> next;
    const std::size_t count = width * static_cast<std::size_t>(sheet.height);
    std::uint32_t* cells = texel_of_cell_.data() + sheet.first_cell;
    for (std::size_t i = 0; i < count; ++i)
        if (cells[i] != none)
            ring.push_back(i);
    const auto visit_neighbors = [&](std::size_t i, const auto& visit)
    {
        const std::size_t x = i % width;
        if (x > 0)
            visit(i - 1);
        if (x + 1 < width)
            visit(i + 1);
        if (i >= width)
            visit(i - width);
        if (i + width < count)
            visit(i + width);
    };
    while (!ring.empty())
    {
        next.clear();
        for (const std::size_t i : ring)
            visit_neighbors(i,
                            [&](std::size_t other)
                            {
                                if (cells[other] != none)
                                    return;
                                cells[other] = cells[i];
                                next.push_back(other);
                            });
        ring.swap(next);
    }
}

}  // namespace fresco::synthesize

#include "atlas_figures.h"

#include <fresco/geometry/topology.h>
#include <fresco/raster.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

namespace bench
{
namespace
{

using fresco::Mesh;
using fresco::Vec2d;
using fresco::Vec3d;
using Flat = std::array<Vec2d, 3>;

constexpr double same_texcoord = 1e-6;
constexpr double lost_below = 1e-6;
constexpr double inside_by_texels = 1e-3;

Vec2d texcoord(const Mesh& mesh, std::size_t face, std::size_t corner)
{
    const auto uv = mesh.texcoords[3 * face + corner];
    return {uv.x, uv.y};
}

Flat flat_face(const Mesh& mesh, std::size_t face)
{
    return {texcoord(mesh, face, 0), texcoord(mesh, face, 1), texcoord(mesh, face, 2)};
}

double flat_area(const Flat& t)
{
    return std::abs(cross(t[1] - t[0], t[2] - t[0])) / 2;
}

bool same(Vec2d a, Vec2d b)
{
    return std::abs(a.x - b.x) < same_texcoord && std::abs(a.y - b.y) < same_texcoord;
}

/// Square of Sander's L2 of a face: the mean of the squared singular values of the map from the atlas to the surface.
double square_stretch(const Mesh& mesh, std::size_t face, const Flat& t)
{
    const double twice = cross(t[1] - t[0], t[2] - t[0]);
    Vec3d along_s;
    Vec3d along_t;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vec3d p =
            fresco::vec_cast<double>(mesh.positions[mesh.triangles[face][k]] - mesh.positions[mesh.triangles[face][0]]);
        const Vec2d opposite = t[(k + 2) % 3] - t[(k + 1) % 3];
        along_s += p * (-opposite.y / twice);
        along_t += p * (opposite.x / twice);
    }
    return (dot(along_s, along_s) + dot(along_t, along_t)) / 2;
}

/// Areas of every face on the surface and in the atlas, and their sums.
struct Areas
{
    std::vector<double> surface;
    std::vector<double> atlas;
    double surface_sum = 0;
    double atlas_sum = 0;

    explicit Areas(const Mesh& mesh)
    {
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        {
            surface.push_back(length(fresco::geometry::area_vector(mesh, f)) / 2);
            atlas.push_back(flat_area(flat_face(mesh, f)));
            surface_sum += surface.back();
            atlas_sum += atlas.back();
        }
    }
    /// Texels that a face got over those that its area is worth.
    double worth(std::size_t f) const { return (atlas[f] / atlas_sum) / (surface[f] / surface_sum); }
};

void measure_scale(const Mesh& mesh, const Areas& areas, AtlasFigures& figures)
{
    double stretch = 0;
    double stretched_area = 0;
    double density = 0;
    double squares = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const double area = areas.surface[f];
        if (!(area > 0))
            continue;
        const double worth = areas.worth(f);
        density += area * std::sqrt(worth);
        squares += area * worth;
        figures.squeezed_share += worth < 0.25 ? area / areas.surface_sum : 0;
        if (worth < lost_below)
        {
            ++figures.lost_faces;
            continue;
        }
        stretch += area * square_stretch(mesh, f, flat_face(mesh, f));
        stretched_area += area;
    }
    figures.stretch_l2 = std::sqrt(stretch / stretched_area * areas.atlas_sum / areas.surface_sum);
    density /= areas.surface_sum;
    squares /= areas.surface_sum;
    figures.density_variation = std::sqrt(std::max(squares - density * density, 0.0)) / density;
}

void measure_seams(const Mesh& mesh, AtlasFigures& figures)
{
    fresco::geometry::DisjointSets charts(mesh.triangles.size());
    double inner = 0;
    double cut = 0;
    fresco::geometry::for_each_edge(mesh.triangles, mesh.positions.size(),
                                    [&](std::uint32_t low, std::uint32_t high, std::span<const fresco::geometry::EdgeUse> uses)
                                    {
                                        if (uses.size() != 2)
                                            return;
                                        const auto ends = [&](const fresco::geometry::EdgeUse& use)
                                        {
                                            const Vec2d begin = texcoord(mesh, use.face, use.corner);
                                            const Vec2d end = texcoord(mesh, use.face, (use.corner + 1) % 3);
                                            return use.forward ? std::array{begin, end} : std::array{end, begin};
                                        };
                                        const auto a = ends(uses[0]);
                                        const auto b = ends(uses[1]);
                                        const auto edge = static_cast<double>(length(mesh.positions[high] - mesh.positions[low]));
                                        inner += edge;
                                        if (same(a[0], b[0]) && same(a[1], b[1]))
                                            charts.join(uses[0].face, uses[1].face);
                                        else
                                            cut += edge;
                                    });
    std::set<std::uint32_t> roots;
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
        roots.insert(charts.find(f));
    figures.charts = roots.size();
    figures.seam_length_share = inner > 0 ? cut / inner : 0;
}

bool centre_inside(const Flat& t, Vec2d centre, double turn)
{
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vec2d side = t[(k + 1) % 3] - t[k];
        if (!(turn * cross(side, centre - t[k]) > inside_by_texels * length(side)))
            return false;
    }
    return true;
}

std::size_t overlapping_texels(const Mesh& mesh, int size_px)
{
    fresco::Raster<std::uint8_t> faces(size_px, size_px);
    const auto cell = [&](double x)
    { return std::clamp(static_cast<int>(std::floor(std::clamp(x, 0.0, double(size_px)))), 0, size_px - 1); };
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        Flat t = flat_face(mesh, f);
        for (auto& p : t)
            p = p * static_cast<double>(size_px);
        const double turn = cross(t[1] - t[0], t[2] - t[0]) < 0 ? -1 : 1;
        const auto [x0, x1] = std::minmax({t[0].x, t[1].x, t[2].x});
        const auto [y0, y1] = std::minmax({t[0].y, t[1].y, t[2].y});
        for (int y = cell(y0); y <= cell(y1); ++y)
            for (int x = cell(x0); x <= cell(x1); ++x)
                if (faces.at(x, y) < 2 && centre_inside(t, {x + 0.5, y + 0.5}, turn))
                    ++faces.at(x, y);
    }
    return static_cast<std::size_t>(std::count(faces.values.begin(), faces.values.end(), 2));
}

}  // namespace

AtlasFigures atlas_figures(const Mesh& mesh, int size_px)
{
    if (mesh.texcoords.size() != 3 * mesh.triangles.size())
        throw std::invalid_argument("atlas_figures takes a mesh with texcoords");
    const Areas areas(mesh);
    if (!(areas.surface_sum > 0) || !(areas.atlas_sum > 0))
        throw std::invalid_argument("atlas_figures takes a mesh with area, on the surface and in the atlas");
    AtlasFigures figures;
    figures.used_share = areas.atlas_sum;
    figures.texels_per_cm = size_px * std::sqrt(areas.atlas_sum / areas.surface_sum) / 100;
    measure_scale(mesh, areas, figures);
    measure_seams(mesh, figures);
    figures.overlapping_texels = overlapping_texels(mesh, size_px);
    for (const auto& uv : mesh.texcoords)
        figures.outside_corners += uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1 ? 0 : 1;
    return figures;
}

}  // namespace bench

#include <fresco/geometry/atlas_figures.h>
#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco::geometry
{

namespace
{

using Flat = std::array<Vec2d, 3>;

constexpr double same_texcoord = 1e-6;
constexpr double lost_below = 1e-6;

Vec2d texcoord(const Mesh& mesh, std::size_t face, std::size_t corner)
{
    const auto uv = mesh.texcoords[3 * face + corner];
    return {uv.x, uv.y};
}

Flat flat_face(const Mesh& mesh, std::size_t face)
{
    return {texcoord(mesh, face, 0), texcoord(mesh, face, 1), texcoord(mesh, face, 2)};
}

bool same(Vec2d a, Vec2d b)
{
    return std::abs(a.x - b.x) < same_texcoord && std::abs(a.y - b.y) < same_texcoord;
}

/// Squares of the singular values of the map from the atlas to the surface.
struct Stretch
{
    double mean = 0;
    double largest = 0;
};

Stretch square_stretch(const Mesh& mesh, std::size_t face, const Flat& t)
{
    const double twice = cross(t[1] - t[0], t[2] - t[0]);
    Vec3d along_s;
    Vec3d along_t;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vec3d p = vec_cast<double>(mesh.positions[mesh.triangles[face][k]] - mesh.positions[mesh.triangles[face][0]]);
        const Vec2d opposite = t[(k + 2) % 3] - t[(k + 1) % 3];
        along_s += p * (-opposite.y / twice);
        along_t += p * (opposite.x / twice);
    }
    const double a = dot(along_s, along_s);
    const double b = dot(along_s, along_t);
    const double c = dot(along_t, along_t);
    return {(a + c) / 2, (a + c + std::hypot(a - c, 2 * b)) / 2};
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
            surface.push_back(length(area_vector(mesh, f)) / 2);
            const Flat t = flat_face(mesh, f);
            atlas.push_back(std::abs(cross(t[1] - t[0], t[2] - t[0])) / 2);
            surface_sum += surface.back();
            atlas_sum += atlas.back();
        }
    }
    /// Texels that a face got over those that its area is worth.
    double worth(std::size_t f) const { return (atlas[f] / atlas_sum) / (surface[f] / surface_sum); }
};

void report_scale(RunContext& run, const Mesh& mesh, const Areas& areas)
{
    double stretch = 0;
    double largest = 0;
    double stretched_area = 0;
    double density = 0;
    double squares = 0;
    double squeezed = 0;
    std::size_t lost = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const double area = areas.surface[f];
        if (!(area > 0))
            continue;
        const double worth = areas.worth(f);
        density += area * std::sqrt(worth);
        squares += area * worth;
        squeezed += worth < 0.25 ? area / areas.surface_sum : 0;
        if (worth < lost_below)
        {
            ++lost;
            continue;
        }
        const auto of_face = square_stretch(mesh, f, flat_face(mesh, f));
        stretch += area * of_face.mean;
        largest = std::max(largest, of_face.largest);
        stretched_area += area;
    }
    density /= areas.surface_sum;
    squares /= areas.surface_sum;
    run.report("stretch_l2", std::sqrt(stretch / stretched_area * areas.atlas_sum / areas.surface_sum));
    run.report("stretch_linf", std::sqrt(largest * areas.atlas_sum / areas.surface_sum));
    run.report("density_variation", std::sqrt(std::max(squares - density * density, 0.0)) / density);
    run.report("squeezed_share", squeezed);
    run.report("lost_faces", lost);
}

/// An edge between two faces is a seam unless both have the same texcoords at its ends.
void report_seams(RunContext& run, const Mesh& mesh)
{
    numerics::DisjointSets charts(mesh.triangles.size());
    double inner = 0;
    double seams = 0;
    for_each_edge(mesh.triangles, mesh.positions.size(),
                  [&](std::uint32_t low, std::uint32_t high, std::span<const EdgeUse> uses)
                  {
                      if (uses.size() != 2)
                          return;
                      const auto ends = [&](const EdgeUse& use)
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
                          seams += edge;
                  });
    run.report("charts", charts.count());
    run.report("seam_length_m", seams);
    run.report("seam_length_share", inner > 0 ? seams / inner : 0);
}

}  // namespace

void report_atlas(RunContext& run, const Mesh& mesh, int size_px)
{
    const Areas areas(mesh);
    run.report("used_share", areas.atlas_sum);
    run.report("texels_per_cm", size_px * std::sqrt(areas.atlas_sum / areas.surface_sum) / 100);
    report_scale(run, mesh, areas);
    report_seams(run, mesh);
    run.report("outside_corners", std::ranges::count_if(mesh.texcoords, [](Vec2f uv)
                                                        { return !(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1); }));
}

}  // namespace fresco::geometry

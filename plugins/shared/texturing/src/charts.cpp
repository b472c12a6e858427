#include <fresco/texturing/charts.h>

#include <fresco/numerics/disjoint_sets.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <tuple>

namespace fresco::texturing
{
namespace
{
/// A face's side, its ends ordered by vertex.
struct Side
{
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    std::uint32_t face = 0;
    std::array<Vec2f, 2> uv;  ///< At low, at high.
};

std::vector<Side> sorted_sides(const Mesh& mesh)
{
    const std::vector<std::uint32_t> welded = welded_vertices(mesh);
    std::vector<Side> sides;
    sides.reserve(mesh.triangles.size() * 3);
    for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
        for (std::size_t i = 0; i < 3; ++i)
        {
            const std::size_t j = (i + 1) % 3;
            Side side{welded[mesh.triangles[face][i]],
                      welded[mesh.triangles[face][j]],
                      face,
                      {mesh.texcoords[3 * std::size_t{face} + i], mesh.texcoords[3 * std::size_t{face} + j]}};
            if (side.low > side.high)
            {
                std::swap(side.low, side.high);
                std::swap(side.uv[0], side.uv[1]);
            }
            if (side.low != side.high)
                sides.push_back(side);
        }
    std::sort(sides.begin(), sides.end(),
              [](const Side& a, const Side& b) { return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face); });
    return sides;
}

}  // namespace

std::vector<std::uint32_t> welded_vertices(const Mesh& mesh)
{
    std::vector<std::uint32_t> order(mesh.positions.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&](std::uint32_t v)
    {
        const Vec3f p = mesh.positions[v];
        return std::tuple(p.x, p.y, p.z);
    };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b)
              { return std::tuple_cat(key(a), std::tuple(a)) < std::tuple_cat(key(b), std::tuple(b)); });
    std::vector<std::uint32_t> welded(order.size());
    std::uint32_t first = 0;
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        if (i == 0 || key(order[i]) != key(order[i - 1]))
            first = order[i];
        welded[order[i]] = first;
    }
    return welded;
}

Charts find_charts(const Mesh& mesh)
{
    const std::vector<Side> sides = sorted_sides(mesh);
    Charts charts;
    numerics::DisjointSets sets(mesh.triangles.size());
    for (std::size_t i = 1; i < sides.size(); ++i)
    {
        const Side& a = sides[i - 1];
        const Side& b = sides[i];
        if (a.low != b.low || a.high != b.high)
            continue;
        if (a.uv == b.uv)
            sets.join(a.face, b.face);
        else
            charts.seams.push_back({a.face, b.face, a.uv, b.uv});
    }
    charts.of_face.resize(mesh.triangles.size());
    for (std::uint32_t face = 0; face < charts.of_face.size(); ++face)
    {
        const std::uint32_t root = sets.find(face);
        charts.of_face[face] = root == face ? charts.count++ : charts.of_face[root];
    }
    return charts;
}

}  // namespace fresco::texturing

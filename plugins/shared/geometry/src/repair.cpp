#include <fresco/geometry/repair.h>
#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace fresco::geometry
{
namespace
{

/// Merges the ends of edges without length, so that the faces around stay joined when the collapsed face goes.
std::size_t weld_zero_edges(Mesh& mesh)
{
    numerics::DisjointSets same(mesh.positions.size());
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            if (mesh.positions[t[k]] == mesh.positions[t[(k + 1) % 3]])
                same.join(t[k], t[(k + 1) % 3]);
    const std::size_t welded = mesh.positions.size() - same.count();
    if (welded > 0)
        for (auto& t : mesh.triangles)
            for (auto& v : t)
                v = same.find(v);
    return welded;
}

/// Removes the faces for which `drop(face)` holds. Returns how many.
template <class Drop>
std::size_t remove_faces(Mesh& mesh, const Drop& drop)
{
    const std::size_t before = mesh.triangles.size();
    std::size_t next = 0;
    for (std::size_t f = 0; f < before; ++f)
        if (!drop(f))
            mesh.triangles[next++] = mesh.triangles[f];
    mesh.triangles.resize(next);
    return before - next;
}

/// Opposite of each half of an edge (face * 3 + corner); `none` at borders.
using Mates = std::vector<std::uint32_t>;

std::uint32_t half(const EdgeUse& use)
{
    return use.face * 3 + use.corner;
}

/// Joins the faces around an edge, those first that continue each other best: whose normals are nearest.
void join_best(const Mesh& mesh, std::uint32_t low, std::span<const EdgeUse> uses, Mates& mates)
{
    const auto join = [&](const EdgeUse& a, const EdgeUse& b)
    {
        mates[half(a)] = half(b);
        mates[half(b)] = half(a);
    };
    if (uses.size() == 2 && uses[0].forward != uses[1].forward)
        return join(uses[0], uses[1]);

    const auto place = [&](std::uint32_t v) { return vec_cast<double>(mesh.positions[v]); };
    const auto axis = normalized(place(uses[0].high) - place(low));
    const auto zero = area_vector(mesh, uses[0].face);
    const auto quarter = cross(axis, zero);
    std::vector<EdgeUse> forward, backward;
    std::vector<double> forward_angles, backward_angles;
    for (const auto& use : uses)
    {
        const auto normal = area_vector(mesh, use.face);
        (use.forward ? forward : backward).push_back(use);
        (use.forward ? forward_angles : backward_angles).push_back(std::atan2(dot(normal, quarter), dot(normal, zero)));
    }
    for (const auto& [a, b] : numerics::nearest_pairs(forward_angles, backward_angles))
        join(forward[a], backward[b]);
}

/// The triangles after copying vertices so that two corners share a vertex only if joined edges connect them.
std::vector<Triangle> split_fans(const Mesh& mesh, const Mates& mates, std::vector<std::uint32_t>& origin)
{
    numerics::DisjointSets corners(mates.size());
    for (std::uint32_t a = 0; a < mates.size(); ++a)
        if (const auto b = mates[a]; b != none)
            corners.join(a, b / 3 * 3 + (b + 1 - b / 3 * 3) % 3);

    origin.resize(mesh.positions.size());
    std::iota(origin.begin(), origin.end(), 0u);
    std::vector<bool> taken(mesh.positions.size(), false);
    std::vector<std::uint32_t> vertex_of(mates.size());
    std::vector<Triangle> triangles(mesh.triangles.size());
    for (std::uint32_t c = 0; c < mates.size(); ++c)
    {
        const auto root = corners.find(c);
        if (root == c)
        {
            const auto v = mesh.triangles[c / 3][c % 3];
            vertex_of[c] = taken[v] ? static_cast<std::uint32_t>(origin.size()) : v;
            if (taken[v])
                origin.push_back(v);
            taken[v] = true;
        }
        triangles[c / 3][c % 3] = vertex_of[root];
    }
    return triangles;
}

/// Cuts off faces that make an edge of the split surface complex: pinched fans and one-sided bands.
std::size_t detach_misfits(const std::vector<Triangle>& triangles, std::size_t vertex_count, Mates& mates)
{
    std::vector<std::uint32_t> misfits;
    for_each_edge(triangles, vertex_count,
                  [&](std::uint32_t, std::uint32_t, std::span<const EdgeUse> uses)
                  {
                      if (uses.size() < 2 || (uses.size() == 2 && mates[half(uses[0])] == half(uses[1])))
                          return;
                      for (const auto& use : uses.subspan(1))
                          if (mates[half(uses[0])] != half(use))
                              misfits.push_back(use.face);
                  });
    std::sort(misfits.begin(), misfits.end());
    misfits.erase(std::unique(misfits.begin(), misfits.end()), misfits.end());
    for (const auto f : misfits)
        for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h)
            if (const auto other = mates[h]; other != none)
            {
                mates[other] = none;
                mates[h] = none;
            }
    return misfits.size();
}

}  // namespace

Mesh repaired(const Mesh& input, RepairReport& report, const Progress& progress)
{
    Mesh mesh;
    mesh.positions = input.positions;
    mesh.colors = input.colors;
    mesh.triangles = input.triangles;
    report.vertices_welded = weld_zero_edges(mesh);
    report.degenerate_faces = remove_faces(mesh, [&](std::size_t f) { return !(length(area_vector(mesh, f)) > 0); });
    const auto copies = duplicate_faces(mesh);
    report.duplicate_faces = remove_faces(mesh, [&](std::size_t f) { return copies[f]; });
    progress.check_canceled();

    Mates mates(mesh.triangles.size() * 3, none);
    for_each_edge(mesh.triangles, mesh.positions.size(),
                  [&](std::uint32_t low, std::uint32_t, std::span<const EdgeUse> uses)
                  {
                      if (uses.size() > 2 || (uses.size() == 2 && uses[0].forward == uses[1].forward))
                          ++report.complex_edges;
                      join_best(mesh, low, uses, mates);
                  });
    progress.check_canceled();

    std::vector<std::uint32_t> origin;
    auto triangles = split_fans(mesh, mates, origin);
    while (const auto detached = detach_misfits(triangles, origin.size(), mates))
    {
        progress.check_canceled();
        report.faces_detached += detached;
        triangles = split_fans(mesh, mates, origin);
    }
    report.vertices_added = origin.size() - mesh.positions.size();
    Mesh out;
    for (const auto v : origin)
    {
        out.positions.push_back(mesh.positions[v]);
        if (!mesh.colors.empty())
            out.colors.push_back(mesh.colors[v]);
    }
    out.triangles = std::move(triangles);
    drop_unused_vertices(out);
    report.vertices_unused = origin.size() - out.positions.size() - report.vertices_welded;
    return out;
}

void drop_unused_vertices(Mesh& mesh)
{
    std::vector<std::uint32_t> index(mesh.positions.size(), none);
    for (const auto& t : mesh.triangles)
        for (const auto v : t)
            index[v] = 0;
    std::uint32_t kept = 0;
    for (std::size_t v = 0; v < index.size(); ++v)
        if (index[v] != none)
        {
            mesh.positions[kept] = mesh.positions[v];
            if (!mesh.colors.empty())
                mesh.colors[kept] = mesh.colors[v];
            index[v] = kept++;
        }
    mesh.positions.resize(kept);
    mesh.colors.resize(mesh.colors.empty() ? 0 : kept);
    for (auto& t : mesh.triangles)
        t = {index[t[0]], index[t[1]], index[t[2]]};
}

std::vector<bool> duplicate_faces(const Mesh& mesh)
{
    const auto turned = [&](std::uint32_t f)
    {
        auto t = mesh.triangles[f];
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        return t;
    };
    // Faces by their smallest vertex; the few of one vertex are compared with each other.
    const numerics::Buckets by_vertex(mesh.positions.size(),
                                      [&](const auto& add)
                                      {
                                          for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
                                              add(std::ranges::min(mesh.triangles[f]), f);
                                      });
    std::vector<bool> duplicate(mesh.triangles.size(), false);
    std::vector<std::uint32_t> around;
    for (std::size_t v = 0; v < by_vertex.count(); ++v)
    {
        around.assign(by_vertex[v].begin(), by_vertex[v].end());
        std::sort(around.begin(), around.end(),
                  [&](auto a, auto b) { return std::pair(turned(a), a) < std::pair(turned(b), b); });
        for (std::size_t i = 1; i < around.size(); ++i)
            if (turned(around[i]) == turned(around[i - 1]))
                duplicate[around[i]] = true;
    }
    return duplicate;
}

}  // namespace fresco::geometry

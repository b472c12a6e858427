#pragma once

#include <fresco/mesh.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

/// \file What touches what in an indexed triangle mesh.

namespace fresco::geometry
{

/// "No face", "no chart".
inline constexpr std::uint32_t none = 0xffffffffu;

/// Position of a number in an ascending list, or `none`.
inline std::uint32_t place_of(std::span<const std::uint32_t> list, std::uint32_t number)
{
    const auto at = std::ranges::lower_bound(list, number);
    return at != list.end() && *at == number ? static_cast<std::uint32_t>(at - list.begin()) : none;
}

/// One face's use of an undirected edge.
struct EdgeUse
{
    std::uint32_t high;    ///< The edge's larger vertex.
    std::uint32_t face;    ///< The face …
    std::uint32_t corner;  ///< … and its corner (0..2) where the edge begins; it ends at the next corner.
    bool forward;          ///< The face runs along it from the smaller to the larger vertex.
};

/// Calls visit(low, high, uses) once per undirected edge, in ascending (low, high); uses are in ascending (face, corner). Edges
/// from a vertex to itself are left out. All indices must be < vertex_count.
template <class Visit>
void for_each_edge(std::span<const Triangle> triangles, std::size_t vertex_count, Visit visit)
{
    std::vector<std::uint32_t> begin(vertex_count + 1, 0);
    const auto each = [&](auto&& act)
    {
        for (std::size_t f = 0; f < triangles.size(); ++f)
            for (std::uint32_t k = 0; k < 3; ++k)
            {
                const auto a = triangles[f][k];
                const auto b = triangles[f][(k + 1) % 3];
                if (a != b)
                    act(std::min(a, b), EdgeUse{std::max(a, b), static_cast<std::uint32_t>(f), k, a < b});
            }
    };
    each([&](std::uint32_t low, const EdgeUse&) { ++begin[low + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<EdgeUse> uses(begin.back());
    auto next = begin;
    each([&](std::uint32_t low, const EdgeUse& use) { uses[next[low]++] = use; });
    for (std::uint32_t low = 0; low < vertex_count; ++low)
    {
        const auto bucket = std::span(uses).subspan(begin[low], begin[low + 1] - begin[low]);
        // In a total order, since a stable sort would allocate for each vertex.
        std::ranges::sort(bucket, {}, [](const EdgeUse& use) { return std::tuple(use.high, use.face, use.corner); });
        for (std::size_t i = 0, j = 0; i < bucket.size(); i = j)
        {
            while (j < bucket.size() && bucket[j].high == bucket[i].high)
                ++j;
            visit(low, bucket[i].high, std::span<const EdgeUse>(bucket.subspan(i, j - i)));
        }
    }
}

/// F x 3: the face across the edge from corner k to the next, or `none` where the surface ends: at borders, where more than two
/// faces meet, and where two faces disagree about which side is outside.
using Neighbors = std::vector<std::array<std::uint32_t, 3>>;
Neighbors face_neighbors(std::span<const Triangle> triangles, std::size_t vertex_count);

/// Parts of a mesh.
struct SurfaceCounts
{
    std::size_t faces = 0;
    std::size_t vertices = 0;    ///< Named by at least one face.
    std::size_t components = 0;  ///< Sets of faces connected through edges.
    std::size_t edges = 0;
    std::size_t border_edges = 0;   ///< Edges of exactly one face.
    std::size_t complex_edges = 0;  ///< Edges of three or more faces, or of two that disagree about the outside.
    double border_length_m = 0;
    double area_m2 = 0;
};
SurfaceCounts count_surface(const Mesh& mesh);

/// Twice the area times the normal, in double precision.
Vec3d area_vector(const Mesh& mesh, std::size_t face);

}  // namespace fresco::geometry

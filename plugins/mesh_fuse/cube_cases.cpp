#include "cube_cases.h"

#include <algorithm>
#include <vector>

namespace fuse
{
namespace
{

constexpr int corner_count = 8;

std::array<CubeEdge, 12> make_edges()
{
    std::array<CubeEdge, 12> edges{};
    std::size_t count = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int corner = 0; corner < corner_count; ++corner)
            if ((corner >> axis & 1) == 0)
                edges[count++] = {corner, axis};
    return edges;
}

int edge_between(int a, int b)
{
    const auto& edges = cube_edges();
    const auto found = std::ranges::find_if(edges, [&](const CubeEdge& edge)
                                            { return edge.corner == std::min(a, b) && (1 << edge.axis) == (a ^ b); });
    return static_cast<int>(found - edges.begin());
}

/// The corners of the six faces, counter-clockwise seen from outside the cube.
std::array<std::array<int, 4>, 6> make_faces()
{
    std::array<std::array<int, 4>, 6> faces{};
    for (int axis = 0; axis < 3; ++axis)
    {
        const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, far = 1 << axis;
        faces[static_cast<std::size_t>(2 * axis)] = {0, v, u | v, u};
        faces[static_cast<std::size_t>(2 * axis + 1)] = {far, far | u, far | u | v, far | v};
    }
    return faces;
}

/// Whether two edges of the cube have a face in common.
bool share_face(int first, int second)
{
    const auto lies_in = [](const CubeEdge& edge, int axis, int side)
    { return edge.axis != axis && (edge.corner >> axis & 1) == side; };
    const auto &a = cube_edges()[static_cast<std::size_t>(first)], &b = cube_edges()[static_cast<std::size_t>(second)];
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
            if (lies_in(a, axis, side) && lies_in(b, axis, side))
                return true;
    return false;
}

/// Where the surface crosses the faces: for each edge that it meets, the next one around it.
std::array<int, 12> follow_faces(int inside)
{
    std::array<int, 12> next{};
    next.fill(-1);
    const auto is_inside = [&](int corner) { return (inside >> corner & 1) != 0; };
    for (const std::array<int, 4>& face : make_faces())
        for (std::size_t i = 0; i < 4; ++i)
        {
            if (!is_inside(face[i]) || is_inside(face[(i + 3) % 4]))
                continue;
            std::size_t last = i;
            while (is_inside(face[(last + 1) % 4]))
                last = (last + 1) % 4;
            // Around the corners inside from i to last, which the surface cuts off.
            next[static_cast<std::size_t>(edge_between(face[(i + 3) % 4], face[i]))] =
                edge_between(face[last], face[(last + 1) % 4]);
        }
    return next;
}

/// Adds a polygon as a fan, from a corner whose diagonals lie in no face of the cube: there is one in each case.
void add_fan(const std::vector<int>& loop, CubeCase& result)
{
    const std::size_t count = loop.size();
    const auto fits = [&](std::size_t first)
    {
        for (std::size_t i = 2; i + 1 < count; ++i)
            if (share_face(loop[first], loop[(first + i) % count]))
                return false;
        return true;
    };
    std::size_t first = 0;
    while (first + 1 < count && !fits(first))
        ++first;
    const auto edge = [&](std::size_t i) { return static_cast<std::uint8_t>(loop[(first + i) % count]); };
    for (std::size_t i = 1; i + 1 < count; ++i)
        result.triangles[static_cast<std::size_t>(result.count++)] = {edge(0), edge(i), edge(i + 1)};
}

CubeCase make_case(int inside)
{
    CubeCase result;
    std::array<int, 12> next = follow_faces(inside);
    for (int& start : next)
    {
        std::vector<int> loop;
        for (int* at = &start; *at >= 0;)
        {
            const int edge = *at;
            *at = -1;
            loop.push_back(edge);
            at = &next[static_cast<std::size_t>(edge)];
        }
        if (!loop.empty())
            add_fan(loop, result);
    }
    return result;
}

}  // namespace

const std::array<CubeEdge, 12>& cube_edges()
{
    static const std::array<CubeEdge, 12> edges = make_edges();
    return edges;
}

const std::array<CubeCase, 256>& cube_cases()
{
    static const std::array<CubeCase, 256> cases = []
    {
        std::array<CubeCase, 256> all{};
        for (int inside = 0; inside < 256; ++inside)
            all[static_cast<std::size_t>(inside)] = make_case(inside);
        return all;
    }();
    return cases;
}

}  // namespace fuse

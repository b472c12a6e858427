#include "components.h"

#include <fresco/geometry/topology.h>
#include <fresco/numerics/disjoint_sets.h>

#include <algorithm>
#include <cstdint>
#include <vector>

using namespace fresco;

namespace fuse
{

std::size_t remove_small_components(double min_area_m2, Mesh& mesh)
{
    numerics::DisjointSets sets(mesh.positions.size());
    for (const Triangle& t : mesh.triangles)
    {
        sets.join(t[0], t[1]);
        sets.join(t[1], t[2]);
    }
    std::vector<double> areas(mesh.positions.size(), 0);
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
        areas[sets.find(mesh.triangles[face][0])] += length(geometry::area_vector(mesh, face)) / 2;
    const auto is_small = [&](std::uint32_t vertex) { return areas[sets.find(vertex)] < min_area_m2; };
    const auto count =
        static_cast<std::size_t>(std::ranges::count_if(areas, [&](double area) { return area > 0 && area < min_area_m2; }));

    std::vector<std::uint32_t> number(mesh.positions.size(), geometry::none);
    std::uint32_t kept = 0;
    for (std::uint32_t vertex = 0; vertex < mesh.positions.size(); ++vertex)
        if (!is_small(vertex))
        {
            mesh.positions[kept] = mesh.positions[vertex];
            number[vertex] = kept++;
        }
    mesh.positions.resize(kept);
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return number[t[0]] == geometry::none; });
    for (Triangle& t : mesh.triangles)
        t = {number[t[0]], number[t[1]], number[t[2]]};
    return count;
}

}  // namespace fuse

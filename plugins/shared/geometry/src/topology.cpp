#include <fresco/geometry/topology.h>

#include <fresco/numerics/numerics.h>

namespace fresco::geometry
{

Neighbors face_neighbors(std::span<const Triangle> triangles, std::size_t vertex_count)
{
    Neighbors neighbors(triangles.size(), {none, none, none});
    for_each_edge(triangles, vertex_count,
                  [&](std::uint32_t, std::uint32_t, std::span<const EdgeUse> uses)
                  {
                      if (uses.size() != 2 || uses[0].forward == uses[1].forward || uses[0].face == uses[1].face)
                          return;
                      neighbors[uses[0].face][uses[0].corner] = uses[1].face;
                      neighbors[uses[1].face][uses[1].corner] = uses[0].face;
                  });
    return neighbors;
}

SurfaceCounts count_surface(const Mesh& mesh)
{
    SurfaceCounts counts;
    counts.faces = mesh.triangles.size();
    std::vector<bool> used(mesh.positions.size(), false);
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        for (const auto v : mesh.triangles[f])
            used[v] = true;
        counts.area_m2 += 0.5 * length(area_vector(mesh, f));
    }
    counts.vertices = static_cast<std::size_t>(std::count(used.begin(), used.end(), true));

    numerics::DisjointSets sets(mesh.triangles.size());
    for_each_edge(mesh.triangles, mesh.positions.size(),
                  [&](std::uint32_t low, std::uint32_t high, std::span<const EdgeUse> uses)
                  {
                      ++counts.edges;
                      if (uses.size() == 1)
                      {
                          ++counts.border_edges;
                          counts.border_length_m +=
                              length(vec_cast<double>(mesh.positions[high]) - vec_cast<double>(mesh.positions[low]));
                      }
                      else if (uses.size() > 2 || uses[0].forward == uses[1].forward)
                          ++counts.complex_edges;
                      for (const auto& use : uses.subspan(1))
                          sets.join(uses[0].face, use.face);
                  });
    counts.components = sets.count();
    return counts;
}

Vec3d area_vector(const Mesh& mesh, std::size_t face)
{
    const auto& t = mesh.triangles[face];
    const auto a = vec_cast<double>(mesh.positions[t[0]]);
    return cross(vec_cast<double>(mesh.positions[t[1]]) - a, vec_cast<double>(mesh.positions[t[2]]) - a);
}

}  // namespace fresco::geometry

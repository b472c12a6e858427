#include "carried_labels.h"

#include <fresco/geometry/closest_triangle.h>
#include <fresco/geometry/topology.h>
#include <fresco/parallel.h>

#include <cmath>

using namespace fresco;

CarriedLabels carried_labels(const LabeledSurface& from, const Mesh& to, double within_m, const Progress& progress)
{
    const auto corner = [](const Mesh& mesh, std::uint32_t vertex) { return vec_cast<double>(mesh.positions[vertex]); };
    std::vector<geometry::Corners3> triangles;
    triangles.reserve(from.mesh.triangles.size());
    for (const auto& [a, b, c] : from.mesh.triangles)
        triangles.push_back({corner(from.mesh, a), corner(from.mesh, b), corner(from.mesh, c)});
    const geometry::ClosestTriangle tree(std::move(triangles));

    CarriedLabels result;
    result.label_of_face.assign(to.triangles.size(), no_label);
    std::vector<double> distances(to.triangles.size());
    constexpr std::size_t faces_per_piece = 4096;
    parallel_for(to.triangles.size(), faces_per_piece, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t f = begin; f < end; ++f)
                     {
                         const auto& [a, b, c] = to.triangles[f];
                         const auto closest = tree.find((corner(to, a) + corner(to, b) + corner(to, c)) * (1.0 / 3), within_m);
                         distances[f] = closest.distance;
                         if (std::isfinite(closest.distance))
                             result.label_of_face[f] = from.label_of_face[closest.triangle];
                     }
                 });
    double covered = 0;
    double total = 0;
    for (std::size_t f = 0; f < distances.size(); ++f)
    {
        const double area = length(geometry::area_vector(to, f)) / 2;
        total += area;
        if (std::isfinite(distances[f]))
        {
            covered += area;
            result.mean_distance_m += area * distances[f];
        }
    }
    result.covered_share = total > 0 ? covered / total : 0;
    result.mean_distance_m = covered > 0 ? result.mean_distance_m / covered : 0;
    return result;
}

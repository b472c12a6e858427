#include "carried_labels.h"
#include "catch.h"
#include "shapes.h"

#include <fresco/geometry/closest_triangle.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace fresco;

namespace
{

/// A bumpy square of 1 m whose faces are labeled by random.
LabeledSurface bumpy(std::uint32_t squares)
{
    LabeledSurface surface;
    surface.mesh = shapes::grid(squares, [](float x, float y) { return 0.1F * std::sin(7 * x) * std::cos(5 * y); });
    surface.names = {"a", "b", "c"};
    Random random(9);
    for (std::size_t f = 0; f < surface.mesh.triangles.size(); ++f)
    {
        const auto label = static_cast<std::uint32_t>(random.uniform() * 4);
        surface.label_of_face.push_back(label == 3 ? no_label : label);
    }
    return surface;
}

}  // namespace

TEST_CASE("carried labels: those of the closest face, as a look at every face finds it")
{
    const LabeledSurface from = bumpy(13);
    Mesh to = bumpy(20).mesh;
    Random random(4);
    for (Vec3f& p : to.positions)
        p.z += static_cast<float>(0.06 * random.uniform());
    constexpr double within_m = 0.03;
    const CarriedLabels carried = carried_labels(from, to, within_m, Progress{});
    double covered = 0;
    double total = 0;
    for (std::size_t f = 0; f < to.triangles.size(); ++f)
    {
        const auto corner = [](const Mesh& mesh, std::uint32_t v) { return vec_cast<double>(mesh.positions[v]); };
        const auto& [a, b, c] = to.triangles[f];
        const Vec3d middle = (corner(to, a) + corner(to, b) + corner(to, c)) * (1.0 / 3);
        std::vector<double> distances;
        for (const auto& [p, q, r] : from.mesh.triangles)
            distances.push_back(length(
                geometry::closest_point({corner(from.mesh, p), corner(from.mesh, q), corner(from.mesh, r)}, middle) - middle));
        const double least = *std::ranges::min_element(distances);
        // Where the closest point is on an edge, several faces have it.
        std::set<std::uint32_t> labels;
        for (std::size_t g = 0; g < distances.size(); ++g)
            if (distances[g] < least + 1e-9)
                labels.insert(from.label_of_face[g]);
        const double area = length(cross(corner(to, b) - corner(to, a), corner(to, c) - corner(to, a))) / 2;
        total += area;
        covered += least < within_m ? area : 0;
        CHECK((least < within_m ? labels.contains(carried.label_of_face[f]) : carried.label_of_face[f] == no_label));
    }
    CHECK(carried.covered_share == Approx(covered / total));
    CHECK(carried.covered_share > 0.3);
    CHECK(carried.covered_share < 0.9);
}

TEST_CASE("carried labels: a mesh keeps its own")
{
    const LabeledSurface from = bumpy(13);
    const CarriedLabels carried = carried_labels(from, from.mesh, 0.01, Progress{});
    CHECK(carried.label_of_face == from.label_of_face);
    CHECK(carried.covered_share == Approx(1));
    CHECK(carried.mean_distance_m < 1e-6);
}

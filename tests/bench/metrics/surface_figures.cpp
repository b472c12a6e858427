#include "surface_figures.h"

#include <fresco/geometry/surface_search.h>
#include <fresco/geometry/topology.h>
#include <fresco/parallel.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bench
{
namespace
{

using fresco::Mesh;
using fresco::Vec3d;
using fresco::geometry::SurfaceSearch;
using Corners3 = std::array<Vec3d, 3>;

constexpr std::size_t points_per_piece = 1024;

Corners3 corners_of(const Mesh& mesh, const fresco::Triangle& t)
{
    return {fresco::vec_cast<double>(mesh.positions[t[0]]), fresco::vec_cast<double>(mesh.positions[t[1]]),
            fresco::vec_cast<double>(mesh.positions[t[2]])};
}

/// Border edges as triangles that name their end twice.
Mesh border_of(const Mesh& mesh)
{
    Mesh result;
    result.positions = mesh.positions;
    fresco::geometry::for_each_edge(mesh.triangles, mesh.positions.size(),
                                    [&](std::uint32_t low, std::uint32_t high, auto uses)
                                    {
                                        if (uses.size() == 1)
                                            result.triangles.push_back({low, high, high});
                                    });
    return result;
}

/// Picks indices with a likelihood in proportion to their weights.
class Wheel
{
  public:
    template <class Weight>
    Wheel(std::size_t count, Weight weight)
    {
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i)
            sums_.push_back(sum += weight(i));
    }
    std::size_t pick(fresco::Random& random) const
    {
        const double at = random.uniform() * sums_.back();
        const auto found = std::upper_bound(sums_.begin(), sums_.end(), at);
        return std::min(static_cast<std::size_t>(found - sums_.begin()), sums_.size() - 1);
    }

  private:
    std::vector<double> sums_;
};

std::vector<Vec3d> border_samples(const Mesh& border, std::size_t count, std::uint64_t seed)
{
    fresco::Random random(seed);
    const auto edge_of = [&](std::size_t i) { return corners_of(border, border.triangles[i]); };
    const Wheel wheel(border.triangles.size(), [&](std::size_t i) { return length(edge_of(i)[1] - edge_of(i)[0]); });
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto edge = edge_of(wheel.pick(random));
        points.push_back(edge[0] + (edge[1] - edge[0]) * random.uniform());
    }
    return points;
}

DistanceFigures distances(const std::vector<Vec3d>& points, const SurfaceSearch& to, int threads)
{
    std::vector<double> result(points.size());
    fresco::parallel_for(points.size(), points_per_piece, threads,
                         [&](std::size_t begin, std::size_t end)
                         {
                             for (std::size_t i = begin; i < end; ++i)
                                 result[i] = std::sqrt(to.nearest(points[i]).squared_distance);
                         });
    return distance_figures(std::move(result));
}

/// The center of a face and the points halfway to its corners.
std::array<Vec3d, 4> probes(const Corners3& t)
{
    const Vec3d center = (t[0] + t[1] + t[2]) * (1.0 / 3);
    return {center, (center + t[0]) * 0.5, (center + t[1]) * 0.5, (center + t[2]) * 0.5};
}

}  // namespace

DistanceFigures distance_figures(std::vector<double> distances)
{
    if (distances.empty())
        return {};
    std::sort(distances.begin(), distances.end());
    double sum = 0;
    for (const double d : distances)
        sum += d;
    const auto rank = static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(distances.size())));
    return {sum / static_cast<double>(distances.size()), distances[rank - 1], distances.back()};
}

DistanceFigures TwoSided::both() const
{
    return {(to_reference.mean + from_reference.mean) / 2, std::max(to_reference.p99, from_reference.p99),
            std::max(to_reference.largest, from_reference.largest)};
}

std::vector<Vec3d> surface_samples(const Mesh& mesh, std::size_t count, std::uint64_t seed)
{
    fresco::Random random(seed);
    const Wheel wheel(mesh.triangles.size(), [&](std::size_t f) { return length(fresco::geometry::area_vector(mesh, f)); });
    std::vector<Vec3d> points;
    points.reserve(count);
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto t = corners_of(mesh, mesh.triangles[wheel.pick(random)]);
        // Evenly over the triangle: the root spreads the rows, whose lengths grow from one corner.
        const double row = std::sqrt(random.uniform());
        const double along = random.uniform();
        points.push_back(t[0] * (1 - row) + t[1] * (row * (1 - along)) + t[2] * (row * along));
    }
    return points;
}

TwoSided surface_distance(const Mesh& result, const Mesh& reference, std::size_t samples, std::uint64_t seed, int threads)
{
    return {distances(surface_samples(result, samples, seed), SurfaceSearch(reference), threads),
            distances(surface_samples(reference, samples, seed), SurfaceSearch(result), threads)};
}

TwoSided border_distance(const Mesh& result, const Mesh& reference, std::size_t samples, std::uint64_t seed, int threads)
{
    const auto ours = border_of(result);
    const auto theirs = border_of(reference);
    if (ours.triangles.empty() && theirs.triangles.empty())
        return {};
    if (ours.triangles.empty() || theirs.triangles.empty())
    {
        constexpr double far = std::numeric_limits<double>::infinity();
        return {{far, far, far}, {far, far, far}};
    }
    return {distances(border_samples(ours, samples, seed), SurfaceSearch(theirs), threads),
            distances(border_samples(theirs, samples, seed), SurfaceSearch(ours), threads)};
}

FaceFaults face_faults(const Mesh& result, const Mesh& reference, int threads)
{
    const SurfaceSearch below(reference);
    std::vector<std::uint8_t> flipped(result.triangles.size());
    std::vector<std::uint8_t> degenerate(result.triangles.size());
    fresco::parallel_for(result.triangles.size(), points_per_piece, threads,
                         [&](std::size_t begin, std::size_t end)
                         {
                             for (std::size_t f = begin; f < end; ++f)
                             {
                                 const Vec3d normal = normalized(fresco::geometry::area_vector(result, f));
                                 degenerate[f] = normal == Vec3d{} ? 1 : 0;
                                 double agreement = 0;
                                 for (const Vec3d& p : probes(corners_of(result, result.triangles[f])))
                                     agreement +=
                                         dot(normal, normalized(fresco::geometry::area_vector(reference, below.nearest(p).face)));
                                 flipped[f] = agreement < 0 ? 1 : 0;
                             }
                         });
    const auto complex_edges = [](const Mesh& mesh)
    { return static_cast<std::int64_t>(fresco::geometry::count_surface(mesh).complex_edges); };
    return {static_cast<std::size_t>(std::count(flipped.begin(), flipped.end(), 1)),
            static_cast<std::size_t>(std::count(degenerate.begin(), degenerate.end(), 1)),
            complex_edges(result) - complex_edges(reference)};
}

}  // namespace bench

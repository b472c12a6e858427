#pragma once

#include <fresco/mesh.h>

#include <cstddef>
#include <cstdint>
#include <vector>

/// \file How near a simplified surface is to the one it was made from, whatever made it. Meters.

namespace bench
{

/// Of sampled distances.
struct DistanceFigures
{
    double mean = 0;
    double p99 = 0;
    double largest = 0;
};
/// The 99th percentile is the smallest value that at least 99 % of the values do not exceed; all 0 for no values.
DistanceFigures distance_figures(std::vector<double> distances);

/// Both ways between two sets of points.
struct TwoSided
{
    DistanceFigures to_reference;    ///< From the result to what it was made from: what was added.
    DistanceFigures from_reference;  ///< The other way: what was lost.
    /// The mean of both means, the larger percentile, the larger maximum.
    DistanceFigures both() const;
};

/// `count` points on the faces, as likely everywhere on the surface; the same for the same seed.
std::vector<fresco::Vec3d> surface_samples(const fresco::Mesh& mesh, std::size_t count, std::uint64_t seed);

/// From `samples` points on each surface to the closest point of the other. Both need a face with area.
TwoSided surface_distance(const fresco::Mesh& result, const fresco::Mesh& reference, std::size_t samples, std::uint64_t seed,
                          int threads);

/// The same between the borders (edges of one face), by points that are as likely everywhere along them. All 0 where neither has
/// a border; where only one has, every distance is infinite.
TwoSided border_distance(const fresco::Mesh& result, const fresco::Mesh& reference, std::size_t samples, std::uint64_t seed,
                         int threads);

/// What went wrong with faces.
struct FaceFaults
{
    std::size_t flipped = 0;     ///< Look against the reference's surface below them, by four points of each face.
    std::size_t degenerate = 0;  ///< Have no area.
    std::int64_t non_manifold_edges_created =
        0;  ///< Edges of three or more faces, or of two that disagree; less the reference's.
};
FaceFaults face_faults(const fresco::Mesh& result, const fresco::Mesh& reference, int threads);

}  // namespace bench

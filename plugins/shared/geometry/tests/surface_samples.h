#pragma once

#include <fresco/geometry/surface_search.h>
#include <fresco/geometry/topology.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

/// \file How near a surface is to another, whatever made it. Meters.

/// From points that are as likely everywhere on a surface to the closest point of the other, in rising order.
inline std::vector<double> sampled_distances(const fresco::Mesh& from, const fresco::Mesh& to)
{
    std::vector<double> areas;
    for (std::size_t f = 0; f < from.triangles.size(); ++f)
        areas.push_back(length(fresco::geometry::area_vector(from, f)));
    std::mt19937 random(1);
    std::discrete_distribution<std::size_t> face(areas.begin(), areas.end());
    std::uniform_real_distribution<double> uniform;
    const fresco::geometry::SurfaceSearch search(to);
    std::vector<double> distances(50'000);
    for (double& distance : distances)
    {
        const auto& [a, b, c] = from.triangles[face(random)];
        const auto corner = [&](std::uint32_t v) { return fresco::vec_cast<double>(from.positions[v]); };
        // Evenly over the triangle: the root spreads the rows, whose lengths grow from one corner.
        const double row = std::sqrt(uniform(random));
        const double along = uniform(random);
        const auto point = corner(a) * (1 - row) + corner(b) * (row * (1 - along)) + corner(c) * (row * along);
        distance = std::sqrt(search.nearest(point).squared_distance);
    }
    std::ranges::sort(distances);
    return distances;
}

inline double mean(const std::vector<double>& distances)
{
    return std::accumulate(distances.begin(), distances.end(), 0.0) / static_cast<double>(distances.size());
}

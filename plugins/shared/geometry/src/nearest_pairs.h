#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace fresco::geometry
{

/// Pairs directions of two sets, nearest first, each direction at most once, until one set is used up: what taking all pairs in
/// ascending order of their angle gives, in O(n log n) time and O(n) memory.
/// Angles in radians from -pi to pi; returns (index into a, index into b). Among equal angles the choice depends on the order of
/// the input alone.
std::vector<std::pair<std::uint32_t, std::uint32_t>> nearest_pairs(std::span<const double> a, std::span<const double> b);

}  // namespace fresco::geometry

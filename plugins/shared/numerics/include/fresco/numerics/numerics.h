#pragma once

#include <fresco/math.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

/// \file Small algorithms on numbers that several plugins need: disjoint sets, sorting in linear time, the median, linear
/// systems, rotations, pairs of directions.

namespace fresco::numerics
{

/// Disjoint sets of [0, count) with path halving; the smallest member represents its set, so results do not depend on call order.
class DisjointSets
{
  public:
    explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t find(std::uint32_t i)
    {
        while (parent_[i] != i)
            i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b)
    {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parent_;
};

/// Sorts by the upper 32 bits, keeping the order of equal ones, in linear time; no upper half exceeds `largest`.
void sort_by_upper_half(std::vector<std::uint64_t>& entries, std::uint32_t largest);

/// A number that is larger for a larger `value`; NaN is above or below all others.
inline std::uint32_t ordered_key(float value)
{
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

/// The middle one of the values in ascending order, of two the upper. \pre not empty
double median(std::vector<double> values);

/// Solves A x = b in place by Cholesky, for each column of `right`: N x `columns`, row-major. `matrix`: N x N, row-major,
/// symmetric and positive definite; only its lower triangle is read, and overwritten.
void solve_symmetric(std::span<double> matrix, std::span<double> right, std::size_t columns = 1);

/// The rotation by the vector's length, in radians, about its direction (Rodrigues).
Mat3 rotation_by(Vec3d turn);

/// The rotation of the quaternion w + x i + y j + z k, whose length is 1.
Mat3 rotation_of(double w, double x, double y, double z);

/// Pairs directions of two sets, nearest first, each direction at most once, until one set is used up: what taking all pairs in
/// ascending order of their angle gives, in O(n log n) time and O(n) memory.
/// Angles in radians from -pi to pi; returns (index into a, index into b). Among equal angles the choice depends only on the
/// order of the input.
std::vector<std::pair<std::uint32_t, std::uint32_t>> nearest_pairs(std::span<const double> a, std::span<const double> b);

}  // namespace fresco::numerics

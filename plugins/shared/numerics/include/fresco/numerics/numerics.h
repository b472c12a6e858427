#pragma once

#include <fresco/math.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

/// \file Small algorithms on numbers that several plugins need: disjoint sets, buckets, boxes, sorting in linear time, the
/// median, linear systems, rotations, pairs of directions.

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
    /// Number of sets.
    std::size_t count() const
    {
        std::size_t roots = 0;
        for (std::uint32_t i = 0; i < parent_.size(); ++i)
            roots += parent_[i] == i ? 1 : 0;
        return roots;
    }
    /// The set of each member, counted from 0 in the order of their smallest ones.
    std::vector<std::uint32_t> numbers()
    {
        std::vector<std::uint32_t> result(parent_.size());
        std::uint32_t next = 0;
        for (std::uint32_t i = 0; i < result.size(); ++i)
            result[i] = find(i) == i ? next++ : result[find(i)];
        return result;
    }

  private:
    std::vector<std::uint32_t> parent_;
};

/// Numbers in buckets, those of each in the order in which they were given. Linear time.
class Buckets
{
  public:
    /// `each(add)` calls add(bucket, number) for all numbers, and is called twice; buckets are below `count`.
    template <class Each>
    Buckets(std::size_t count, const Each& each) : begins_(count + 1, 0)
    {
        each([&](std::size_t bucket, std::uint32_t) { ++begins_[bucket + 1]; });
        std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
        numbers_.resize(begins_.back());
        auto next = begins_;
        each([&](std::size_t bucket, std::uint32_t number) { numbers_[next[bucket]++] = number; });
    }

    std::size_t count() const { return begins_.size() - 1; }
    std::span<const std::uint32_t> operator[](std::size_t bucket) const
    {
        return std::span(numbers_).subspan(begins_[bucket], begins_[bucket + 1] - begins_[bucket]);
    }

  private:
    std::vector<std::size_t> begins_;
    std::vector<std::uint32_t> numbers_;
};

/// The axis-parallel box around points; without points, its lower corner is above its upper one.
template <class T>
struct Bounds
{
    static constexpr T far = std::numeric_limits<T>::infinity();

    Vec3<T> low{far, far, far};
    Vec3<T> high{-far, -far, -far};

    void add(Vec3<T> p)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
};

double cosine_deg(double degrees);

/// Unit vectors from +z to -z, evenly spread over the sphere (a Fibonacci lattice).
std::vector<Vec3d> spread_directions(std::size_t count);

/// Replaces numbers by 0, 1, 2 … in the order in which they first occur, and returns what each of these stood for. `end`: above
/// all of them; the greatest 32-bit number stays as it is.
std::vector<std::uint32_t> number_by_first(std::span<std::uint32_t> numbers, std::size_t end);

/// The lowest number with an equal `key`, for each of [0, count).
template <class Key>
std::vector<std::uint32_t> first_equal(std::size_t count, const Key& key)
{
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); });
    std::vector<std::uint32_t> first(count);
    for (std::size_t i = 0; i < count; ++i)
        first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
    return first;
}

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

#include "catch.h"

#include <fresco/numerics/numerics.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using namespace fresco::numerics;
using namespace fresco;

TEST_CASE("entries are sorted by their upper half and keep their order where it is equal")
{
    Random random(3);
    for (const std::uint32_t largest : {0U, 5U, 2047U, 2048U, 1U << 23U, std::numeric_limits<std::uint32_t>::max()})
    {
        std::vector<std::uint64_t> entries;
        for (int i = 0; i < 3000; ++i)
            entries.push_back(random.bits() % (std::uint64_t{largest} + 1) << 32U | (random.bits() & 0xffffffffU));
        auto expected = entries;
        std::stable_sort(expected.begin(), expected.end(), [](auto a, auto b) { return a >> 32U < b >> 32U; });
        sort_by_upper_half(entries, largest);
        CHECK(entries == expected);
    }
}

TEST_CASE("keys of numbers are ordered as the numbers are")
{
    const float numbers[] = {-std::numeric_limits<float>::infinity(), -3e9F, -1.5F, -1e-40F, 0.0F, 1e-40F, 0.25F, 0.5F, 7.0F,
                             std::numeric_limits<float>::infinity()};
    for (std::size_t i = 1; i < std::size(numbers); ++i)
        CHECK(ordered_key(numbers[i - 1]) < ordered_key(numbers[i]));
}

TEST_CASE("rotations turn by the right hand, given as a vector or as a quaternion")
{
    constexpr double quarter = std::numbers::pi / 2;
    CHECK(length(numerics::rotation_by({0, 0, quarter}) * Vec3d{1, 0, 0} - Vec3d{0, 1, 0}) < 1e-15);
    CHECK(length(numerics::rotation_by({quarter, 0, 0}) * Vec3d{0, 1, 0} - Vec3d{0, 0, 1}) < 1e-15);
    CHECK(numerics::rotation_by({}) == Mat3{});
    CHECK(numerics::rotation_of(1, 0, 0, 0) == Mat3{});
    const Vec3d turn{0.3, -0.7, 1.1};
    const Vec3d v = normalized(turn) * std::sin(length(turn) / 2);
    const Mat3 expected = numerics::rotation_by(turn);
    const Mat3 found = numerics::rotation_of(std::cos(length(turn) / 2), v.x, v.y, v.z);
    for (std::size_t i = 0; i < 9; ++i)
        CHECK(found.m[i] == Approx(expected.m[i]).margin(1e-15));
    CHECK(RigidTransform{expected, {}}.rotation_error() < 1e-15);
}

TEST_CASE("symmetric systems are solved")
{
    // A = B Bᵀ + 1 with random B; x is known.
    constexpr std::size_t n = 23, columns = 3;
    Random random(2);
    std::vector<double> b(n * n), a(n * n), x(n * columns), right(n * columns);
    for (auto* values : {&b, &x})
        for (double& value : *values)
            value = random.normal();
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
        {
            for (std::size_t k = 0; k < n; ++k)
                a[i * n + j] += b[i * n + k] * b[j * n + k];
            a[i * n + j] += i == j;
            for (std::size_t c = 0; c < columns; ++c)
                right[i * columns + c] += a[i * n + j] * x[j * columns + c];
        }
    for (std::size_t i = 0; i < n; ++i)  // Only the lower triangle is read.
        for (std::size_t j = i + 1; j < n; ++j)
            a[i * n + j] = std::nan("");
    numerics::solve_symmetric(a, right, columns);
    for (std::size_t i = 0; i < right.size(); ++i)
        CHECK(right[i] == Approx(x[i]).margin(1e-8));
}

namespace
{

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// All pairs in ascending order of their angle.
Pairs pairs_of_all(const std::vector<double>& a, const std::vector<double>& b)
{
    struct Candidate
    {
        double angle;
        std::uint32_t a, b;
    };
    std::vector<Candidate> all;
    for (std::uint32_t i = 0; i < a.size(); ++i)
        for (std::uint32_t j = 0; j < b.size(); ++j)
            all.push_back({std::acos(std::cos(a[i] - b[j])), i, j});
    std::sort(all.begin(), all.end(), [](const auto& x, const auto& y) { return x.angle < y.angle; });
    std::vector<bool> a_taken(a.size()), b_taken(b.size());
    Pairs result;
    for (const auto& candidate : all)
        if (!a_taken[candidate.a] && !b_taken[candidate.b])
        {
            result.emplace_back(candidate.a, candidate.b);
            a_taken[candidate.a] = b_taken[candidate.b] = true;
        }
    return result;
}

}  // namespace

TEST_CASE("pairs are those of all pairs in order")
{
    Random random(7);
    const auto count = [&] { return static_cast<std::size_t>(random.below(12)); };
    for (int round = 0; round < 200; ++round)
    {
        std::vector<double> a(count()), b(count());
        for (auto* side : {&a, &b})
            for (auto& angle : *side)
                angle = (random.uniform() * 2 - 1) * std::numbers::pi;
        CHECK(nearest_pairs(a, b) == pairs_of_all(a, b));
    }
}

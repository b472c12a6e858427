#include "catch.h"
#include "nearest_pairs.h"

#include <fresco/random.h>

#include <algorithm>
#include <cmath>
#include <numbers>

using fresco::geometry::nearest_pairs;

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

TEST_CASE("directions pair by hand, across the end of the circle too")
{
    CHECK(nearest_pairs(std::vector<double>{}, std::vector<double>{1}).empty());
    CHECK(nearest_pairs(std::vector<double>{0.5, 1}, std::vector<double>{}).empty());
    CHECK(nearest_pairs(std::vector<double>{-3}, std::vector<double>{3}) == Pairs{{0, 0}});
    // 3.1 and -3.1 are 0.08 apart; 3.0 is left with 1.0.
    CHECK(nearest_pairs(std::vector<double>{3.0, 3.1}, std::vector<double>{1.0, -3.1}) == Pairs{{1, 1}, {0, 0}});
    // The nearest pair goes first even where that leaves the others far apart.
    CHECK(nearest_pairs(std::vector<double>{0, 1}, std::vector<double>{0.9, 2.5}) == Pairs{{1, 0}, {0, 1}});
    CHECK(nearest_pairs(std::vector<double>{1, 1, 1}, std::vector<double>{1, 1, 1}).size() == 3);
}

TEST_CASE("pairs are those of all pairs in order")
{
    fresco::Random random(7);
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

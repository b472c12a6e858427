#include "../src/nearest_point.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace fresco;
using namespace fresco::texturing;

TEST_CASE("the nearest point is the one that a look at all finds")
{
    std::vector<Vec3f> points;
    unsigned seed = 7;
    const auto next = [&seed]
    {
        seed = seed * 1664525U + 1013904223U;
        return static_cast<float>(seed >> 8U) / 16777216.0F;
    };
    for (int i = 0; i < 300; ++i)
        points.push_back({next(), next(), std::floor(next() * 4) / 4});  // some planes
    points.push_back(points[17]);                                        // twice
    const NearestPoint tree(points);
    CHECK(tree.find(points[17]) == 17);
    for (int i = 0; i < 300; ++i)
    {
        const Vec3f query{next() * 2 - 0.5F, next() * 2 - 0.5F, next() * 2 - 0.5F};
        std::size_t best = 0;
        for (std::size_t p = 1; p < points.size(); ++p)
            if (dot(points[p] - query, points[p] - query) < dot(points[best] - query, points[best] - query))
                best = p;
        CHECK(tree.find(query) == best);
    }
}

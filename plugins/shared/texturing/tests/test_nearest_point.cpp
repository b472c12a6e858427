#include "../src/nearest_point.h"
#include "catch.h"

#include <fresco/random.h>

#include <cmath>

using namespace fresco;
using namespace fresco::texturing;

TEST_CASE("the nearest point is the one that a look at all finds")
{
    std::vector<Vec3f> points;
    Random random(7);
    const auto next = [&random] { return static_cast<float>(random.uniform()); };
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

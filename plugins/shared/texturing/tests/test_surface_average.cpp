#include "catch.h"

#include <fresco/error.h>
#include <fresco/texturing/surface_average.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

struct Sample
{
    Vec3f point, normal, color;
};

std::vector<Sample> random_samples(std::size_t count)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, 1);
    const auto draw = [&] { return Vec3f{unit(random), unit(random), unit(random)}; };
    std::vector<Sample> samples(count);
    for (Sample& s : samples)
        s = {draw(), normalized(draw() * 2 - Vec3f{1, 1, 1}), draw()};
    return samples;
}

/// How much one sample counts at another, written out: over all nodes of the grid, and the six directions.
double weight(const Sample& a, const Sample& b, double spacing)
{
    const auto hat = [&](float at, int node) { return std::max(0.0, 1 - std::abs(at / spacing - node)); };
    const auto common = [&](float x, float y)
    {
        double sum = 0;
        for (int node = 0; node * spacing < 1 + spacing; ++node)
            sum += hat(x, node) * hat(y, node);
        return sum;
    };
    double directions = 0;
    for (const auto& [x, y] : {std::pair{a.normal.x, b.normal.x}, {a.normal.y, b.normal.y}, {a.normal.z, b.normal.z}})
        if (x * y > 0)
            directions += double{x} * x * y * y;
    return common(a.point.x, b.point.x) * common(a.point.y, b.point.y) * common(a.point.z, b.point.z) * directions;
}

}  // namespace

TEST_CASE("surface average: equals the weighted mean over all samples")
{
    const auto samples = random_samples(300);
    SurfaceAverage average({0, 0, 0}, {1, 1, 1}, 0.2, "split_cm");
    for (const Sample& s : samples)
        average.add(s.point, s.normal, s.color);
    for (const Sample& at : random_samples(40))
    {
        Vec3d sum;
        double total = 0;
        for (const Sample& s : samples)
        {
            const double w = weight(at, s, average.spacing_m());
            sum += vec_cast<double>(s.color) * w;
            total += w;
        }
        const Vec3f found = SurfaceAverage::Lookup(average).at(at.point, at.normal, {-1, -1, -1});
        if (total > 1e-3)
            CHECK(length(vec_cast<double>(found) - sum * (1 / total)) < 1e-4);
    }
}

TEST_CASE("surface average: far from all samples the caller decides, and an endless grid is refused")
{
    SurfaceAverage average({0, 0, 0}, {1, 1, 1}, 0.05, "split_cm");
    average.add({0.1F, 0.1F, 0.1F}, {0, 0, 1}, {1, 1, 1});
    CHECK(SurfaceAverage::Lookup(average).at({0.9F, 0.9F, 0.9F}, {0, 0, 1}, {0.25F, 0.5F, 0.75F}) == Vec3f{0.25F, 0.5F, 0.75F});
    CHECK_THROWS_WITH(SurfaceAverage({0, 0, 0}, {1000, 1000, 10}, 0.01, "split_cm"),
                      Catch::Contains("too large for means over 1 cm") && Catch::Contains("increase split_cm"));
}

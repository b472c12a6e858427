#include "catch.h"

#include <fresco/evaluation/statistics.h>
#include <fresco/random.h>

#include <cmath>
#include <vector>

using namespace fresco;
using namespace fresco::evaluation;

namespace
{
constexpr Bootstrap usual{.resamples = 2000, .seed = 1};
}

TEST_CASE("Pearson's correlation of pairs worked out by hand")
{
    // Deviations (-1.5, -0.5, 0.5, 1.5) and (-1, -2, 1, 2): 6 / sqrt(5 * 10).
    CHECK(pearson(std::vector<double>{1, 2, 3, 4}, std::vector<double>{2, 1, 4, 5}) == Approx(6 / std::sqrt(50.0)));
    CHECK(pearson(std::vector<double>{1, 2, 3}, std::vector<double>{7, 5, 3}) == Approx(-1));
    CHECK(std::isnan(pearson(std::vector<double>{1, 2, 3}, std::vector<double>{4, 4, 4})));
    CHECK(std::isnan(pearson(std::vector<double>{1}, std::vector<double>{4})));
    CHECK(std::isnan(mean({})));
}

TEST_CASE("the bootstrap covers the true mean about as often as it says")
{
    Random random(11);
    int covered = 0;
    for (int trial = 0; trial < 200; ++trial)
    {
        std::vector<double> values;
        for (int i = 0; i < 40; ++i)
            values.push_back(random.normal());
        const Interval interval = bootstrap_mean(values, {.resamples = 400, .seed = 1});
        covered += interval.low <= 0 && interval.high >= 0;
    }
    CHECK(covered >= 178);
    CHECK(covered <= 198);
}

TEST_CASE("the bootstrap is the same for the same seed and leaves out what is undefined")
{
    const std::vector<double> values{1, 5, 2, 8, 3};
    const Interval one = bootstrap_mean(values, {.resamples = 300, .seed = 7});
    const Interval again = bootstrap_mean(values, {.resamples = 300, .seed = 7});
    CHECK(one.low == again.low);
    CHECK(one.high == again.high);
    CHECK(one.low >= 1);
    CHECK(one.high <= 8);
    CHECK(std::isnan(bootstrap_mean(std::vector<double>{3}, usual).low));
    const auto never = [](std::span<const std::size_t>) { return std::nan(""); };
    CHECK(std::isnan(bootstrap_interval(5, never, usual).high));
    const auto often = [](std::span<const std::size_t> drawn) { return drawn[0] == 0 ? std::nan("") : 2.0; };
    CHECK(bootstrap_interval(5, often, usual).low == 2.0);
}

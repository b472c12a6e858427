#include "schedule.h"

#include "catch.h"

#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>

using namespace fresco::optimize;

namespace
{

constexpr ScheduleOptions usual{.epochs = 1,
                                .repeats_count = 1,
                                .max_steps = 0,
                                .shuffled = true,
                                .rate = 1,
                                .decay = Decay::cosine,
                                .decay_start = 0.5,
                                .step_epochs = 3,
                                .step_factor = 0.1};

Schedule scheduled(std::size_t count, const ScheduleOptions& options)
{
    std::vector<std::size_t> views(count);
    std::iota(views.begin(), views.end(), std::size_t{10});
    return {std::move(views), 0, options};
}

}  // namespace

TEST_CASE("repeats are consecutive and every epoch visits every view")
{
    auto o = usual;
    o.epochs = 3;
    o.repeats_count = 4;
    for (const bool shuffled : {false, true})
    {
        o.shuffled = shuffled;
        const Schedule schedule = scheduled(5, o);
        REQUIRE(schedule.steps() == 60);
        REQUIRE(schedule.visits() == 15);
        for (std::int64_t epoch = 0; epoch < 3; ++epoch)
        {
            std::multiset<std::size_t> seen;
            for (std::int64_t step = epoch * 20; step < epoch * 20 + 20; ++step)
            {
                const auto at = schedule.at(step);
                CHECK(at.epoch == epoch);
                CHECK(at.repeat == step % 4);
                CHECK(at.visit == static_cast<std::size_t>(step / 4));
                CHECK(at.view == schedule.view_of_visit(at.visit));
                seen.insert(at.view);
            }
            for (std::size_t view = 10; view < 15; ++view)
                CHECK(seen.count(view) == 4);
        }
    }
    o.shuffled = false;
    CHECK(scheduled(5, o).at(21).view == 10);
    CHECK(scheduled(5, o).at(7).view == 11);
}

TEST_CASE("max_steps ends the run within a visit")
{
    auto o = usual;
    o.repeats_count = 4;
    o.max_steps = 7;
    const Schedule schedule = scheduled(5, o);
    CHECK(schedule.steps() == 7);
    CHECK(schedule.visits() == 2);
    o.max_steps = 1000;
    CHECK(scheduled(5, o).steps() == 20);
    CHECK_THROWS_AS(scheduled(0, usual), std::invalid_argument);
}

TEST_CASE("the spread order is a permutation whose beginnings cover the recording")
{
    for (const std::size_t count : {1U, 2U, 3U, 4U, 6U, 12U, 125U, 1000U})
        for (std::uint64_t seed = 0; seed < 5; ++seed)
        {
            std::set<std::size_t> seen;
            for (std::size_t i = 0; i < count; ++i)
                seen.insert(spread_index(i, count, seed));
            CHECK(seen.size() == count);
            CHECK(*seen.rbegin() == count - 1);
        }
    // A tenth of the walk leaves no gap of more than a quarter of the recording.
    std::set<std::size_t> first;
    for (std::size_t i = 0; i < 12; ++i)
        first.insert(spread_index(i, 125, 7));
    std::size_t last = 0;
    for (const auto index : first)
    {
        CHECK(index - last <= 31);
        last = index;
    }
    CHECK(spread_index(0, 125, 1) != spread_index(0, 125, 2));
}

TEST_CASE("learning rates by hand")
{
    auto o = usual;
    o.epochs = 10;
    o.rate = 2;
    const Schedule cosine = scheduled(10, o);
    CHECK(cosine.rate(0) == 2);
    CHECK(cosine.rate(50) == 2);
    CHECK(cosine.rate(75) == Approx(1));
    CHECK(cosine.rate(99) > 0);
    CHECK(cosine.rate(99) < 0.01);
    o.decay_start = 1;
    CHECK(scheduled(10, o).rate(99) == 2);
    o.decay = Decay::step;
    const Schedule steps = scheduled(10, o);
    CHECK(steps.rate(29) == 2);
    CHECK(steps.rate(30) == Approx(0.2));
    CHECK(steps.rate(99) == Approx(0.002));
}

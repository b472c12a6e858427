#include "held_out.h"

#include <fresco/error.h>

#include "catch.h"

using namespace fresco;
using namespace fresco::optimize;

namespace
{

std::vector<HeldOutLoss> history(const std::vector<double>& losses)
{
    std::vector<HeldOutLoss> result;
    for (const double loss : losses)
        result.push_back({std::ssize(result) * 10, loss, {loss}});
    return result;
}

}  // namespace

TEST_CASE("held-out views lie in the middles of equal stretches, and the rest is optimized for")
{
    const std::vector<std::size_t> views{0, 2, 4, 6, 8, 10, 12, 14, 16, 18};
    CHECK(split_views(views, 0).trained == views);
    CHECK(split_views(views, 0).held_out.empty());
    const auto split = split_views(views, 2);
    CHECK(split.held_out == std::vector<std::size_t>{4, 14});
    CHECK(split.trained == std::vector<std::size_t>{0, 2, 6, 8, 10, 12, 16, 18});
    CHECK(split_views(views, 9).trained.size() == 1);
    CHECK(split_views(views, 9).held_out.size() == 9);
    CHECK_THROWS_WITH(split_views(views, 10), Catch::Contains("only 10 views"));
}

TEST_CASE("a run stops when three measurements gain less than asked for")
{
    CHECK_FALSE(has_stopped_falling({}, 0.01));
    CHECK_FALSE(has_stopped_falling(history({10, 9.99, 9.98}), 0.01));
    CHECK(has_stopped_falling(history({10, 9.99, 9.98, 9.97}), 0.01));
    CHECK_FALSE(has_stopped_falling(history({10, 9.99, 9.98, 9.8}), 0.01));
    CHECK(has_stopped_falling(history({10, 8, 9, 9, 9}), 0.01));
    CHECK_FALSE(has_stopped_falling(history({10, 9.99, 9.98, 9.97}), 0));
}

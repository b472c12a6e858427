#include "catch.h"

#include <fresco/numerics/greedy_cover.h>
#include <fresco/random.h>

#include <algorithm>

using namespace fresco;
using namespace fresco::numerics;

namespace
{

std::vector<SeenCell> range_of(int begin, int end, int worth)
{
    std::vector<SeenCell> seen;
    for (int i = begin; i < end; ++i)
        seen.emplace_back(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(worth));
    return seen;
}

/// The slow and obvious way: look at every frame in every round.
std::vector<Pick> plain_greedy(const std::vector<std::vector<SeenCell>>& frames, std::size_t cell_count)
{
    std::vector<std::uint32_t> best(cell_count);
    std::vector<Pick> order;
    for (;;)
    {
        std::int64_t most = 0;
        std::size_t which = 0;
        for (std::size_t i = 0; i < frames.size(); ++i)
        {
            std::int64_t gain = 0;
            for (const auto cell : frames[i])
                if (cell.worth() > best[cell.cell()])
                    gain += cell.worth() - best[cell.cell()];
            if (gain > most)
            {
                most = gain;
                which = i;
            }
        }
        if (most == 0)
            return order;
        Pick pick{which, 0};
        for (const auto cell : frames[which])
        {
            pick.new_cells += best[cell.cell()] == 0 ? 1 : 0;
            best[cell.cell()] = std::max(best[cell.cell()], cell.worth());
        }
        order.push_back(pick);
    }
}

}  // namespace

TEST_CASE("the frame that adds most is picked, then what adds most to it")
{
    // The second adds 40 to the first's 60 cells, the third only 35; the fourth sees nothing new, but ten cells better.
    const std::vector<std::vector<SeenCell>> frames{
        range_of(0, 60, 100), range_of(60, 100, 100), range_of(30, 95, 90), range_of(0, 10, 120), {}};
    const auto order = greedy_order(frames, 128, Progress{});
    CHECK(order == std::vector<Pick>{{0, 60}, {1, 40}, {3, 0}});
    CHECK(picks_needed(order, 0.6, 9) == 1);
    CHECK(picks_needed(order, 0.601, 9) == 2);
    CHECK(picks_needed(order, 1, 9) == 2);
    CHECK(picks_needed(order, 1, 1) == 1);
    const std::vector<std::size_t> two{1, 2};
    CHECK(cells_seen(frames, two, 128) == 70);
    CHECK(greedy_order({{}, {}}, 4, Progress{}).empty());
}

TEST_CASE("looking at few frames again picks as looking at all of them does, of equal ones the first")
{
    for (std::uint64_t seed = 0; seed < 20; ++seed)
    {
        Random random(seed);
        std::vector<std::vector<SeenCell>> frames(40);
        for (auto& frame : frames)
        {
            const auto begin = static_cast<int>(random.below(400));
            for (int i = begin; i < begin + 100; ++i)
                if (random.below(3) != 0)
                    frame.emplace_back(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(1 + random.below(4)));
        }
        for (std::size_t i = 0; i < 20; ++i)
            frames.push_back(frames[i]);
        const auto order = greedy_order(frames, 512, Progress{});
        CHECK(order == plain_greedy(frames, 512));
        CHECK(order.size() > 5);
    }
}

TEST_CASE("evenly spread numbers lie in the middle of equal stretches")
{
    CHECK(evenly_spread(3, 9) == std::vector<std::size_t>{1, 4, 7});
    CHECK(evenly_spread(4, 4) == std::vector<std::size_t>{0, 1, 2, 3});
    CHECK(evenly_spread(1, 100) == std::vector<std::size_t>{50});
    CHECK(evenly_spread(0, 5).empty());
}

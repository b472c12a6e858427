#include "catch.h"
#include "pipeline/graph.h"

#include <algorithm>
#include <random>

using namespace fresco::host;
using Nodes = std::vector<std::size_t>;

TEST_CASE("The order keeps the file's where it can", "[graph]")
{
    StageGraph graph(5);
    graph.add_edge(3, 0);
    graph.add_edge(3, 2);
    graph.add_edge(0, 4);
    graph.add_edge(2, 4);
    graph.add_edge(2, 4);
    CHECK(graph.order() == Nodes{1, 3, 0, 2, 4});
    CHECK(graph.order({4}) == Nodes{3, 0, 2, 4, 1});
    CHECK(graph.cycles().empty());
    CHECK(graph.needs(4) == Nodes{0, 2});
    CHECK(graph.needed_by(3) == Nodes{0, 2});
    CHECK_THROWS_AS(graph.add_edge(0, 5), std::out_of_range);
}

TEST_CASE("Every group of nodes on a cycle is named by a shortest one", "[graph]")
{
    StageGraph graph(8);
    for (const auto& [from, to] : {std::pair{0, 1}, {1, 2}, {2, 3}, {3, 1}, {2, 1}, {5, 5}, {6, 7}, {0, 6}})
        graph.add_edge(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
    CHECK(graph.cycles() == std::vector<Nodes>{{1, 2}, {5}});
    CHECK(graph.order() == Nodes{0, 4, 6, 7});
}

TEST_CASE("A cycle of many nodes is found", "[graph]")
{
    constexpr std::size_t count = 100'000;
    StageGraph graph(count);
    for (std::size_t i = 0; i < count; ++i)
        graph.add_edge(i, (i + 1) % count);
    const auto cycles = graph.cycles();
    REQUIRE(cycles.size() == 1);
    CHECK(cycles[0].size() == count);
    CHECK(cycles[0][0] == 0);
    CHECK(cycles[0][1] == 1);
}

TEST_CASE("Order and reach agree with an obvious twin on random graphs", "[graph]")
{
    std::mt19937 random(7);
    for (int round = 0; round < 200; ++round)
    {
        const std::size_t count = 1 + random() % 9;
        StageGraph graph(count);
        std::vector<std::vector<bool>> reach(count, std::vector<bool>(count));
        for (std::size_t k = random() % (2 * count); k > 0; --k)
        {
            const std::size_t from = random() % count;
            const std::size_t to = random() % count;
            graph.add_edge(from, to);
            reach[from][to] = true;
        }
        const auto edges = reach;
        for (std::size_t k = 0; k < count; ++k)
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t j = 0; j < count; ++j)
                    reach[i][j] = reach[i][j] || (reach[i][k] && reach[k][j]);
        bool cyclic = false;
        for (std::size_t i = 0; i < count; ++i)
        {
            cyclic = cyclic || reach[i][i];
            for (std::size_t j = 0; j < count; ++j)
                if (i != j)
                {
                    const Nodes above = graph.ancestors(j);
                    CHECK((std::ranges::find(above, i) != above.end()) == reach[i][j]);
                }
        }
        const auto cycles = graph.cycles();
        CHECK(cycles.empty() == !cyclic);
        for (const Nodes& cycle : cycles)
            for (std::size_t i = 0; i < cycle.size(); ++i)
                CHECK(edges[cycle[i]][cycle[(i + 1) % cycle.size()]]);
        const Nodes order = round % 2 == 0 ? graph.order() : graph.order({random() % count});
        CHECK((order.size() == count) == !cyclic);
        for (std::size_t a = 0; a < order.size(); ++a)
            for (std::size_t b = a; b < order.size(); ++b)
                CHECK_FALSE(reach[order[b]][order[a]]);
    }
}

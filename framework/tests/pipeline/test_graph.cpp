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
}

TEST_CASE("Every group of nodes on a cycle is named by one", "[graph]")
{
    StageGraph graph(8);
    for (const auto& [from, to] : {std::pair{0, 1}, {1, 2}, {2, 3}, {3, 1}, {2, 1}, {5, 5}, {6, 7}, {0, 6}})
        graph.add_edge(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
    CHECK(graph.cycles() == std::vector<Nodes>{{1, 2}, {5}});
    CHECK(graph.order() == Nodes{0, 4, 6, 7});
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
            const Nodes above = graph.ancestors(i);
            for (std::size_t j = 0; j < count; ++j)
                CHECK(std::ranges::count(above, j) == (reach[j][i] || j == i));
        }
        const auto cycles = graph.cycles();
        CHECK(cycles.empty() == !cyclic);
        for (const Nodes& cycle : cycles)
            for (std::size_t i = 0; i < cycle.size(); ++i)
                CHECK(edges[cycle[i]][cycle[(i + 1) % cycle.size()]]);
        const Nodes order = graph.order();
        CHECK((order.size() == count) == !cyclic);
        for (std::size_t a = 0; a < order.size(); ++a)
            for (std::size_t b = a; b < order.size(); ++b)
                CHECK_FALSE(reach[order[b]][order[a]]);
    }
}

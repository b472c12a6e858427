#include "pipeline/graph.h"

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/breadth_first_search.hpp>
#include <boost/graph/reverse_graph.hpp>
#include <boost/graph/strong_components.hpp>

#include <algorithm>
#include <functional>
#include <queue>
#include <stdexcept>

namespace fresco::host
{
namespace
{
// Sets of edges: equal edges count once, and neighbors come in ascending order.
using AdjacencyList = boost::adjacency_list<boost::setS, boost::vecS, boost::bidirectionalS>;

constexpr auto none = static_cast<std::size_t>(-1);

/// The node before each on a shortest way from `start` along the edges of `graph`; `none` where no way leads. `start` is its own.
template <class Graph>
std::vector<std::size_t> predecessors(const Graph& graph, std::size_t start)
{
    std::vector<std::size_t> before(boost::num_vertices(graph), none);
    before[start] = start;
    boost::breadth_first_search(
        graph, boost::vertex(start, graph),
        boost::visitor(boost::make_bfs_visitor(boost::record_predecessors(before.data(), boost::on_tree_edge()))));
    return before;
}
}  // namespace

struct StageGraph::Graph
{
    AdjacencyList list;
};

StageGraph::StageGraph(std::size_t nodes) : graph_(std::make_unique<Graph>(Graph{AdjacencyList(nodes)})) {}
StageGraph::~StageGraph() = default;
StageGraph::StageGraph(StageGraph&&) noexcept = default;
StageGraph& StageGraph::operator=(StageGraph&&) noexcept = default;

std::size_t StageGraph::size() const
{
    return boost::num_vertices(graph_->list);
}

void StageGraph::add_edge(std::size_t from, std::size_t to)
{
    if (from >= size() || to >= size())
        throw std::out_of_range("an edge of the stage graph leads to no node");
    boost::add_edge(from, to, graph_->list);
}

std::vector<std::size_t> StageGraph::needs(std::size_t node) const
{
    std::vector<std::size_t> result;
    for (const auto& edge : boost::make_iterator_range(boost::in_edges(node, graph_->list)))
        result.push_back(boost::source(edge, graph_->list));
    std::sort(result.begin(), result.end());
    return result;
}

std::vector<std::size_t> StageGraph::needed_by(std::size_t node) const
{
    std::vector<std::size_t> result;
    for (const auto& edge : boost::make_iterator_range(boost::out_edges(node, graph_->list)))
        result.push_back(boost::target(edge, graph_->list));
    return result;
}

std::vector<std::size_t> StageGraph::ancestors(std::size_t node) const
{
    const std::vector<std::size_t> before = predecessors(boost::make_reverse_graph(graph_->list), node);
    std::vector<std::size_t> nodes;
    for (std::size_t other = 0; other < before.size(); ++other)
        if (before[other] != none)
            nodes.push_back(other);
    return nodes;
}

std::vector<std::vector<std::size_t>> StageGraph::cycles() const
{
    const AdjacencyList& list = graph_->list;
    std::vector<std::size_t> group(size());
    boost::strong_components(list, boost::make_iterator_property_map(group.begin(), boost::get(boost::vertex_index, list)));
    std::vector<std::size_t> members(size());
    for (const std::size_t number : group)
        ++members[number];
    std::vector<bool> seen(size());
    std::vector<std::vector<std::size_t>> result;
    for (std::size_t start = 0; start < size(); ++start)
    {
        const bool alone = members[group[start]] == 1 && !boost::edge(start, start, list).second;
        if (alone || seen[group[start]])
            continue;
        seen[group[start]] = true;
        // The group's other nodes reach `start` again; the nearest that has an edge to it closes a shortest cycle.
        const std::vector<std::size_t> before = predecessors(list, start);
        std::vector<std::size_t> shortest;
        for (const std::size_t last : needs(start))
        {
            if (before[last] == none)
                continue;
            std::vector<std::size_t> cycle{last};
            while (cycle.back() != start)
                cycle.push_back(before[cycle.back()]);
            if (shortest.empty() || cycle.size() < shortest.size())
                shortest = std::move(cycle);
        }
        std::reverse(shortest.begin(), shortest.end());
        if (!shortest.empty())
            result.push_back(std::move(shortest));
    }
    return result;
}

std::vector<std::size_t> StageGraph::order(const std::vector<std::size_t>& early) const
{
    std::vector<bool> is_late(size(), true);
    for (const std::size_t node : early)
        for (const std::size_t needed : ancestors(node))
            is_late[needed] = false;
    using Place = std::pair<bool, std::size_t>;
    std::vector<std::size_t> missing(size());
    std::priority_queue<Place, std::vector<Place>, std::greater<>> ready;
    for (std::size_t node = 0; node < size(); ++node)
    {
        missing[node] = boost::in_degree(node, graph_->list);
        if (missing[node] == 0)
            ready.emplace(is_late[node], node);
    }
    std::vector<std::size_t> result;
    while (!ready.empty())
    {
        const std::size_t node = ready.top().second;
        ready.pop();
        result.push_back(node);
        for (const std::size_t next : needed_by(node))
            if (--missing[next] == 0)
                ready.emplace(is_late[next], next);
    }
    return result;
}

}  // namespace fresco::host

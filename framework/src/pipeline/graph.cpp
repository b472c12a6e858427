#include "pipeline/graph.h"

#include <algorithm>
#include <utility>

namespace fresco::host
{

namespace
{
constexpr auto none = static_cast<std::size_t>(-1);

/// The node before each on a shortest way from `start` along the edges; `none` where no way leads. `start` is its own.
std::vector<std::size_t> predecessors(const std::vector<std::set<std::size_t>>& edges, std::size_t start)
{
    std::vector<std::size_t> before(edges.size(), none);
    before[start] = start;
    std::vector<std::size_t> reached{start};
    for (std::size_t i = 0; i < reached.size(); ++i)
        for (const std::size_t next : edges[reached[i]])
            if (before[next] == none)
            {
                before[next] = reached[i];
                reached.push_back(next);
            }
    return before;
}
}  // namespace

void StageGraph::add_edge(std::size_t from, std::size_t to)
{
    std::set<std::size_t>& needs = needs_.at(to);
    needed_by_.at(from).insert(to);
    needs.insert(from);
}

std::vector<std::size_t> StageGraph::ancestors(std::size_t node) const
{
    const std::vector<std::size_t> before = predecessors(needs_, node);
    std::vector<std::size_t> nodes;
    for (std::size_t other = 0; other < before.size(); ++other)
        if (before[other] != none)
            nodes.push_back(other);
    return nodes;
}

std::vector<std::vector<std::size_t>> StageGraph::cycles() const
{
    std::vector<std::vector<std::size_t>> result;
    if (order().size() == size())
        return result;
    std::vector<bool> told(size());
    for (std::size_t start = 0; start < size(); ++start)
    {
        if (told[start])
            continue;
        const std::vector<std::size_t> before = predecessors(needed_by_, start);
        const auto last = std::ranges::find_if(needs_[start], [&](std::size_t node) { return before[node] != none; });
        if (last == needs_[start].end())
            continue;
        for (const std::size_t node : ancestors(start))
            told[node] = told[node] || before[node] != none;
        std::vector<std::size_t>& cycle = result.emplace_back(1, *last);
        while (cycle.back() != start)
            cycle.push_back(before[cycle.back()]);
        std::ranges::reverse(cycle);
    }
    return result;
}

std::vector<std::size_t> StageGraph::order() const
{
    std::vector<std::size_t> missing(size());
    std::set<std::size_t> ready;
    for (std::size_t node = 0; node < size(); ++node)
        if ((missing[node] = needs_[node].size()) == 0)
            ready.insert(node);
    std::vector<std::size_t> result;
    while (!ready.empty())
    {
        const std::size_t node = result.emplace_back(ready.extract(ready.begin()).value());
        for (const std::size_t next : needed_by_[node])
            if (--missing[next] == 0)
                ready.insert(next);
    }
    return result;
}

}  // namespace fresco::host

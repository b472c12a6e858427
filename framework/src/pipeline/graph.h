#pragma once

#include <cstddef>
#include <set>
#include <vector>

/// \file The order of stages, cycles, and who needs whom. The check of a pipeline builds it; runs follow it.

namespace fresco::host
{

/// A directed graph over the numbers 0 … n-1 in which an edge a → b says that b needs a. Not safe for use by several threads
/// while edges are added.
class StageGraph
{
  public:
    explicit StageGraph(std::size_t nodes) : needs_(nodes), needed_by_(nodes) {}

    std::size_t size() const { return needs_.size(); }
    /// Several equal edges count once. Throws std::out_of_range for an unknown node.
    void add_edge(std::size_t from, std::size_t to);

    /// Direct needs of `node`, and nodes that need it directly; ascending.
    std::vector<std::size_t> needs(std::size_t node) const { return {needs_[node].begin(), needs_[node].end()}; }
    std::vector<std::size_t> needed_by(std::size_t node) const { return {needed_by_[node].begin(), needed_by_[node].end()}; }
    /// `node` and all that it needs, directly or not; ascending.
    std::vector<std::size_t> ancestors(std::size_t node) const;
    /// A cycle through the lowest node of every group of nodes that reach one another: each begins with that node and goes along
    /// the edges. Empty: the graph has no cycle.
    std::vector<std::vector<std::size_t>> cycles() const;
    /// Every node after what it needs, in ascending order where they can be. Without the nodes that are on a cycle or behind one.
    std::vector<std::size_t> order() const;

  private:
    std::vector<std::set<std::size_t>> needs_;
    std::vector<std::set<std::size_t>> needed_by_;
};

}  // namespace fresco::host

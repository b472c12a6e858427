#include "texel_graph.h"

#include <fresco/texturing/seam_links.h>

#include <algorithm>
#include <array>

namespace fresco::texturing
{

namespace
{
/// Makes the nodes and links of the finest level.
class FinestGraph
{
  public:
    FinestGraph(const Charts& charts, const TexelFaces& faces, std::span<const std::uint8_t> seen, std::span<const float> rgb)
        : charts_(charts), faces_(faces), seen_(seen), rgb_(rgb), across_(seam_links(charts, faces)),
          node_(faces.face.size(), TexelGraph::none)
    {
    }

    TexelGraph build()
    {
        graph_.size = faces_.size;
        const auto texels = static_cast<std::uint32_t>(faces_.face.size());
        for (std::uint32_t texel = 0; texel < texels; ++texel)
            if (is_free(texel))
                add_node(texel);
        const std::size_t free_count = graph_.count();
        auto seam = across_.begin();
        for (std::size_t node = 0; node < free_count; ++node)
        {
            const std::uint32_t texel = graph_.place[node];
            graph_.first_link.push_back(graph_.links.size());
            for_each_neighbor(texel, [&](std::uint32_t other) { graph_.links.push_back(node_of(other)); });
            while (seam != across_.end() && seam->first < texel)
                ++seam;
            for (; seam != across_.end() && seam->first == texel; ++seam)
                graph_.links.push_back(node_of(seam->second));
        }
        graph_.first_link.resize(graph_.count() + 1, graph_.links.size());
        graph_.some_texel = graph_.place;
        return std::move(graph_);
    }

  private:
    bool is_free(std::uint32_t texel) const { return faces_.covered(texel) && !seen_[texel]; }
    std::uint32_t chart(std::uint32_t texel) const { return charts_.of_face[faces_.face[texel]]; }

    std::uint32_t node_of(std::uint32_t texel) { return node_[texel] != TexelGraph::none ? node_[texel] : add_node(texel); }

    std::uint32_t add_node(std::uint32_t texel)
    {
        node_[texel] = static_cast<std::uint32_t>(graph_.count());
        graph_.place.push_back(texel);
        graph_.chart.push_back(chart(texel));
        graph_.fixed.push_back(seen_[texel]);
        const std::size_t at = std::size_t{texel} * 3;
        graph_.color.push_back(seen_[texel] ? Vec3f{rgb_[at], rgb_[at + 1], rgb_[at + 2]} : Vec3f{});
        return node_[texel];
    }

    template <class Visit>
    void for_each_neighbor(std::uint32_t texel, const Visit& visit) const
    {
        const auto size = static_cast<std::uint32_t>(faces_.size);
        const auto visit_if_same_chart = [&](std::uint32_t other)
        {
            if (faces_.covered(other) && chart(other) == chart(texel))
                visit(other);
        };
        if (texel % size > 0)
            visit_if_same_chart(texel - 1);
        if (texel % size + 1 < size)
            visit_if_same_chart(texel + 1);
        if (texel >= size)
            visit_if_same_chart(texel - size);
        if (texel / size + 1 < size)
            visit_if_same_chart(texel + size);
    }

    const Charts& charts_;
    const TexelFaces& faces_;
    std::span<const std::uint8_t> seen_;
    std::span<const float> rgb_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> across_;
    std::vector<std::uint32_t> node_;
    TexelGraph graph_;
};

/// Sets finer.parent and makes the parents, still without links.
TexelGraph group_nodes(TexelGraph& finer)
{
    TexelGraph coarse;
    coarse.size = (finer.size + 1) / 2;
    const auto fine_size = static_cast<std::uint32_t>(finer.size);
    const auto size = static_cast<std::uint32_t>(coarse.size);
    std::vector<std::uint32_t> head(std::size_t{size} * size, TexelGraph::none);
    std::vector<std::uint32_t> next;  // the other groups of the same place
    finer.parent.resize(finer.count());
    for (std::size_t node = 0; node < finer.count(); ++node)
    {
        const std::uint32_t place = finer.place[node] / fine_size / 2 * size + finer.place[node] % fine_size / 2;
        std::uint32_t group = head[place];
        while (group != TexelGraph::none && coarse.chart[group] != finer.chart[node])
            group = next[group];
        if (group == TexelGraph::none)
        {
            group = static_cast<std::uint32_t>(coarse.count());
            coarse.place.push_back(place);
            coarse.chart.push_back(finer.chart[node]);
            coarse.some_texel.push_back(finer.some_texel[node]);
            next.push_back(head[place]);
            head[place] = group;
        }
        finer.parent[node] = group;
    }
    return coarse;
}

void average_fixed(const TexelGraph& finer, TexelGraph& coarse)
{
    std::vector<std::uint32_t> weight(coarse.count(), 0);
    coarse.color.assign(coarse.count(), {});
    coarse.fixed.assign(coarse.count(), 0);
    for (std::size_t node = 0; node < finer.count(); ++node)
        if (finer.fixed[node])
        {
            coarse.color[finer.parent[node]] += finer.color[node];
            ++weight[finer.parent[node]];
        }
    for (std::size_t group = 0; group < coarse.count(); ++group)
        if (weight[group] > 0)
        {
            coarse.fixed[group] = 1;
            coarse.color[group] = coarse.color[group] * (1.0F / static_cast<float>(weight[group]));
        }
}

/// The children's links, less those inside a group.
void gather_links(const TexelGraph& finer, TexelGraph& coarse)
{
    const auto for_each_link = [&](const auto& visit)
    {
        for (std::size_t node = 0; node < finer.count(); ++node)
        {
            const std::uint32_t group = finer.parent[node];
            if (coarse.fixed[group])
                continue;
            for (const std::uint32_t other : finer.links_of(node))
                if (finer.parent[other] != group)
                    visit(group, finer.parent[other]);
        }
    };
    coarse.first_link.assign(coarse.count() + 1, 0);
    for_each_link([&](std::uint32_t group, std::uint32_t) { ++coarse.first_link[group + 1]; });
    for (std::size_t group = 0; group < coarse.count(); ++group)
        coarse.first_link[group + 1] += coarse.first_link[group];
    coarse.links.resize(coarse.first_link.back());
    std::vector<std::size_t> end(coarse.first_link.begin(), coarse.first_link.end() - 1);
    for_each_link([&](std::uint32_t group, std::uint32_t other) { coarse.links[end[group]++] = other; });
}
}  // namespace

TexelGraph texel_graph(const Charts& charts, const TexelFaces& faces, std::span<const std::uint8_t> seen,
                       std::span<const float> rgb)
{
    return FinestGraph(charts, faces, seen, rgb).build();
}

TexelGraph coarser_graph(TexelGraph& finer)
{
    TexelGraph coarse = group_nodes(finer);
    average_fixed(finer, coarse);
    gather_links(finer, coarse);
    return coarse;
}

std::vector<std::uint8_t> orphans(const TexelGraph& graph)
{
    // From the free nodes beside a fixed one inwards; links between free nodes run both ways.
    std::vector<std::uint8_t> orphan(graph.count(), 0);
    std::vector<std::size_t> reached;
    for (std::size_t node = 0; node < graph.count(); ++node)
    {
        if (graph.fixed[node])
            continue;
        const auto links = graph.links_of(node);
        const bool beside = std::any_of(links.begin(), links.end(), [&](std::uint32_t other) { return graph.fixed[other] != 0; });
        orphan[node] = !beside;
        if (beside)
            reached.push_back(node);
    }
    while (!reached.empty())
    {
        const std::size_t node = reached.back();
        reached.pop_back();
        for (const std::uint32_t other : graph.links_of(node))
            if (orphan[other])
            {
                orphan[other] = 0;
                reached.push_back(other);
            }
    }
    return orphan;
}

}  // namespace fresco::texturing

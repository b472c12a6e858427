#include <fresco/error.h>
#include <fresco/geometry/surface_search.h>
#include <fresco/math.h>
#include <fresco/texturing/surface_fill.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fresco::texturing
{

namespace
{

/// One level of the fill: nodes on the surface (texels, or groups of texels of one chart) and links between neighbors, also
/// across seams. Only free nodes have links; a link named twice counts twice.
struct TexelGraph
{
    static constexpr std::uint32_t none = TexelFaces::none;

    int size = 0;                           ///< Side of the level's grid: S / 2^level, rounded up.
    std::vector<std::uint32_t> place;       ///< N: y * size + x.
    std::vector<std::uint32_t> chart;       ///< N
    std::vector<std::uint8_t> fixed;        ///< N: 1 = the color is known.
    std::vector<Vec3f> color;               ///< N
    std::vector<std::size_t> first_link;    ///< N + 1
    std::vector<std::uint32_t> links;       ///< Node numbers.
    std::vector<std::uint32_t> parent;      ///< N: the node of the next coarser level; empty in the coarsest.
    std::vector<std::uint32_t> some_texel;  ///< N: a texel of level 0 in it.

    std::size_t count() const { return place.size(); }
    std::span<const std::uint32_t> links_of(std::size_t node) const
    {
        return std::span(links).subspan(first_link[node], first_link[node + 1] - first_link[node]);
    }
};

/// Makes the nodes and links of the finest level: the covered texels that were not seen (free), and the seen ones beside them
/// (fixed, with their color). `seen`: S x S; `rgb`: S x S x 3.
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

/// Groups of 2 x 2 places of one chart; sets finer.parent. A group with a fixed node is fixed, at the mean of these.
TexelGraph coarser_graph(TexelGraph& finer)
{
    TexelGraph coarse = group_nodes(finer);
    average_fixed(finer, coarse);
    gather_links(finer, coarse);
    return coarse;
}

/// N: 1 for free nodes from which no chain of links leads to a fixed one.
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

/// Orphans take their colors in patches of 2^3 texels, smoothed on the finer levels.
constexpr std::size_t orphan_level = 3;
constexpr std::size_t patch_side = std::size_t{1} << orphan_level;
constexpr std::size_t enough_nodes = 512;
constexpr int sweeps_at_coarsest = 200;
constexpr int sweeps_per_level = 16;
constexpr std::size_t nodes_per_check = std::size_t{1} << 20U;

/// One color and one point of the seen surface per patch.
struct SeenSamples
{
    Mesh points;  ///< A face without area for each.
    std::vector<Vec3f> colors;
};

bool is_seen(const TexelFaces& faces, const std::vector<std::uint8_t>& seen, std::size_t texel)
{
    return faces.covered(texel) && seen[texel];
}

SeenSamples sample_seen(const Mesh& mesh, const TexelFaces& faces, const std::vector<std::uint8_t>& seen, const RasterF& rgb)
{
    const auto size = static_cast<std::size_t>(faces.size);
    SeenSamples samples;
    std::vector<std::size_t> patch;
    for (std::size_t y0 = 0; y0 < size; y0 += patch_side)
        for (std::size_t x0 = 0; x0 < size; x0 += patch_side)
        {
            patch.clear();
            for (std::size_t y = y0; y < std::min(y0 + patch_side, size); ++y)
                for (std::size_t x = x0; x < std::min(x0 + patch_side, size); ++x)
                    if (is_seen(faces, seen, y * size + x))
                        patch.push_back(y * size + x);
            if (patch.empty())
                continue;
            const std::size_t middle = patch[patch.size() / 2];
            const auto point = static_cast<std::uint32_t>(samples.points.positions.size());
            samples.points.positions.push_back(texel_position(mesh, faces, middle));
            samples.points.triangles.push_back({point, point, point});
            samples.colors.push_back({rgb.values[3 * middle], rgb.values[3 * middle + 1], rgb.values[3 * middle + 2]});
        }
    return samples;
}

/// Fixes every orphan at the nearest seen color in space.
void anchor_orphans(TexelGraph& graph, const Mesh& mesh, const TexelFaces& faces, const std::vector<std::uint8_t>& seen,
                    const RasterF& rgb)
{
    const std::vector<std::uint8_t> orphan = orphans(graph);
    if (std::find(orphan.begin(), orphan.end(), std::uint8_t{1}) == orphan.end())
        return;
    const SeenSamples samples = sample_seen(mesh, faces, seen, rgb);
    const geometry::SurfaceSearch search(samples.points);
    for (std::size_t node = 0; node < graph.count(); ++node)
        if (orphan[node])
        {
            const Vec3d point = vec_cast<double>(texel_position(mesh, faces, graph.some_texel[node]));
            graph.color[node] = samples.colors[search.nearest(point).face];
            graph.fixed[node] = 1;
        }
}

void relax(TexelGraph& graph, std::size_t node)
{
    if (graph.fixed[node])
        return;
    const auto links = graph.links_of(node);
    if (links.empty())
        return;
    Vec3f sum;
    for (const std::uint32_t other : links)
        sum += graph.color[other];
    graph.color[node] = sum * (1.0F / static_cast<float>(links.size()));
}

/// Gauss-Seidel sweeps, to and fro.
void relax(TexelGraph& graph, int sweeps, const Progress& progress)
{
    const std::size_t count = graph.count();
    for (int sweep = 0; sweep < sweeps; ++sweep)
        for (std::size_t i = 0; i < count; ++i)
        {
            if (i % nodes_per_check == 0)
                progress.check_canceled();
            relax(graph, sweep % 2 == 0 ? i : count - 1 - i);
        }
}

void start_from(const TexelGraph& coarse, TexelGraph& fine)
{
    for (std::size_t node = 0; node < fine.count(); ++node)
        if (!fine.fixed[node])
            fine.color[node] = coarse.color[fine.parent[node]];
}

/// Starts the sweeps of the coarsest level from the mean of the known texels.
void start_from_mean(TexelGraph& graph)
{
    Vec3d sum;
    std::size_t fixed = 0;
    for (std::size_t node = 0; node < graph.count(); ++node)
        if (graph.fixed[node])
        {
            sum += vec_cast<double>(graph.color[node]);
            ++fixed;
        }
    const Vec3f mean = vec_cast<float>(sum * (1.0 / static_cast<double>(std::max<std::size_t>(fixed, 1))));
    for (std::size_t node = 0; node < graph.count(); ++node)
        if (!graph.fixed[node])
            graph.color[node] = mean;
}
}  // namespace

std::size_t fill_unseen(const Mesh& mesh, const Charts& charts, const TexelFaces& faces, const std::vector<std::uint8_t>& seen,
                        RasterF& rgb, const Progress& progress)
{
    std::size_t seen_count = 0;
    std::size_t covered_count = 0;
    for (std::size_t texel = 0; texel < seen.size(); ++texel)
    {
        seen_count += is_seen(faces, seen, texel);
        covered_count += faces.covered(texel);
    }
    if (seen_count == 0)
        throw Error(
            "no frame saw any texel of the mesh's charts, so there is nothing to fill from: check that texture and mesh come "
            "from the same atlas, or set unseen: keep");

    if (seen_count == covered_count)
        return 0;
    std::vector<TexelGraph> levels;
    levels.push_back(FinestGraph(charts, faces, seen, rgb.values).build());
    while (levels.size() <= orphan_level || (levels.back().count() > enough_nodes && levels.back().size > 1))
    {
        progress.check_canceled();
        TexelGraph coarse = coarser_graph(levels.back());
        levels.push_back(std::move(coarse));
        if (levels.size() == orphan_level + 1)
            anchor_orphans(levels.back(), mesh, faces, seen, rgb);
    }

    start_from_mean(levels.back());
    relax(levels.back(), sweeps_at_coarsest, progress);
    while (levels.size() > 1)
    {
        start_from(levels.back(), levels[levels.size() - 2]);
        levels.pop_back();
        relax(levels.back(), sweeps_per_level, progress);
    }

    const TexelGraph& finest = levels.front();
    for (std::size_t node = 0; node < finest.count(); ++node)
        if (!finest.fixed[node])
        {
            const std::size_t at = std::size_t{finest.place[node]} * 3;
            rgb.values[at] = finest.color[node].x;
            rgb.values[at + 1] = finest.color[node].y;
            rgb.values[at + 2] = finest.color[node].z;
        }
    return covered_count - seen_count;
}

}  // namespace fresco::texturing

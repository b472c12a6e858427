#include <fresco/texturing/surface_fill.h>

#include "nearest_point.h"
#include "texel_graph.h"

#include <fresco/error.h>

#include <algorithm>

namespace fresco::texturing
{

namespace
{
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
    std::vector<Vec3f> points;
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
            samples.points.push_back(texel_position(mesh, faces, middle));
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
    const NearestPoint nearest(samples.points);
    for (std::size_t node = 0; node < graph.count(); ++node)
        if (orphan[node])
        {
            graph.color[node] = samples.colors[nearest.find(texel_position(mesh, faces, graph.some_texel[node]))];
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

/// Where the sweeps of the coarsest level begin: the mean of what is known.
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
            "from the same atlas, or set unseen: color");

    if (seen_count == covered_count)
        return 0;
    std::vector<TexelGraph> levels;
    levels.push_back(texel_graph(charts, faces, seen, rgb.values));
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

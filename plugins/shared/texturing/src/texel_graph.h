#pragma once

#include <fresco/math.h>
#include <fresco/texturing/charts.h>
#include <fresco/texturing/texel_faces.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fresco::texturing
{

/// One level of the fill: nodes on the surface (texels, or groups of texels of one chart) and links between neighbors, also
/// across seams. Only free nodes have links; a link named twice counts twice.
struct TexelGraph
{
    static constexpr std::uint32_t none = TexelFaces::none;

    int size = 0;                           ///< Of the level's grid: S / 2^level, rounded up.
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

/// The finest level: the covered texels that were not seen (free), and the seen ones beside them (fixed, with their color).
/// `seen`: S x S; `rgb`: S x S x 3.
TexelGraph texel_graph(const Charts& charts, const TexelFaces& faces, std::span<const std::uint8_t> seen,
                       std::span<const float> rgb);

/// Groups of 2 x 2 places of one chart; sets finer.parent. A group with a fixed node is fixed, at the mean of these.
TexelGraph coarser_graph(TexelGraph& finer);

/// N: 1 for free nodes from which no chain of links leads to a fixed one.
std::vector<std::uint8_t> orphans(const TexelGraph& graph);

}  // namespace fresco::texturing

#pragma once

#include <fresco/texturing/charts.h>
#include <fresco/texturing/texel_faces.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace fresco::texturing
{

/// Pairs of texels that meet across a seam, each in both directions, sorted and unique.
std::vector<std::pair<std::uint32_t, std::uint32_t>> seam_links(const Charts& charts, const TexelFaces& faces);

}  // namespace fresco::texturing

#pragma once

#include <fresco/progress.h>
#include <fresco/texture.h>
#include <fresco/texturing/charts.h>
#include <fresco/texturing/texel_faces.h>

#include <span>
#include <vector>

namespace fresco::texturing
{

/// The mesh's picture with at most `max_px` texels a side; as it is where it is no larger or `max_px` is 0. A texel averages, by
/// area and in linear light, only the texels of its own chart, and the gutter is filled again from the nearest chart texels: no
/// color crosses from chart to chart until one texel holds parts of both, where the chart at its center wins. Equal for any
/// number of threads. The mesh must have passed check_mesh and have texcoords, the picture must be square. Throws Canceled.
Raster8 smaller_picture(const TexturedMesh& textured, int max_px, const Progress& progress);
/// The same for several pictures of a mesh, all of the size that `faces` is for.
std::vector<Raster8> smaller_pictures(const Mesh& mesh, const Charts& charts, const TexelFaces& faces,
                                      std::span<const Raster8> pictures, int max_px, const Progress& progress);

}  // namespace fresco::texturing

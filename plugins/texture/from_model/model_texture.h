#pragma once

#include "model_colors.h"

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstddef>

/// \file Makes the stage's texture: the colors of a model in the atlas of the same surface.

namespace from_model
{

struct ModelTexture
{
    fresco::RasterF picture;       ///< S x S x 3, displayed RGB.
    fresco::Raster8 seen;          ///< 1 for texels with a color of the model.
    std::size_t chart_texels = 0;  ///< Texels with their center in a chart.
    std::size_t far_texels = 0;    ///< Texels among these without a point of the model in reach.
    double mean_distance_m = 0;    ///< From the other texels to the model.
    double largest_distance_m = 0;
};

/// Moves a model's colors to an atlas of the same surface, decimated or not: each texel takes the mean color of the model at the
/// nearest points to n x n places in it, n being the width of a texel in pixels of the model's picture (at most 6). Texels
/// beyond reach continue the others smoothly. The same for any number of threads. Throws Canceled.
ModelTexture transfer_colors(const fresco::Model& model, const ModelColors& colors, const fresco::Mesh& atlas, int size_px,
                             double max_distance_m, fresco::Progress& progress);

}  // namespace from_model

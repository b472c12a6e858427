#pragma once

#include "model_colors.h"

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <cstddef>

namespace from_model
{

struct ModelTexture
{
    fresco::RasterF picture;       ///< S x S x 3, displayed RGB.
    fresco::Raster8 seen;          ///< 1 where the model has a color.
    std::size_t chart_texels = 0;  ///< With their centers in a chart.
    std::size_t far_texels = 0;    ///< Of those, without a point of the model in reach.
    double mean_distance_m = 0;    ///< Of the others, to the model.
    double largest_distance_m = 0;
};

struct TransferRules
{
    int size_px;
    double max_distance_m;  ///< Points of the model farther away do not count.
};

/// Meters per texel of an atlas of `size_px`, on average over its area.
double meters_per_texel(const fresco::Mesh& atlas, int size_px);

/// Moves a model's colors to an atlas of the same surface, decimated or not: each texel takes the mean color of the model at the
/// nearest points to n x n places in it, n being how many pixels of the model's picture a texel is wide (at most 6). Texels
/// beyond reach continue the others. The same for any number of threads. Throws Canceled.
ModelTexture transfer_colors(const fresco::Model& model, const ModelColors& colors, const fresco::Mesh& atlas,
                             const TransferRules& rules, fresco::Progress& progress);

}  // namespace from_model

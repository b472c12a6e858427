#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <cstddef>
#include <cstdint>

/// Treatment of chart texels that no frame saw.
enum class Unseen
{
    fill,  ///< The colors of the seen surface around, see fill_unseen.
    keep   ///< Leaves what the texture holds there.
};

/// Counts of texels whose center lies in a chart.
struct BakeCounts
{
    std::size_t chart_texels = 0;
    std::size_t seen_texels = 0;
};

/// The 8-bit picture of a texture, S x S x 3: layers collapsed, unseen texels filled, the gutter filled from the nearest chart
/// texels. Equal for any number of threads. The mesh must have passed check_mesh and have texcoords. Throws Error, Canceled.
fresco::Raster8 bake(const fresco::Texture& texture, const fresco::Mesh& mesh, Unseen unseen, BakeCounts& counts,
                     fresco::Progress& progress);

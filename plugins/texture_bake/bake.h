#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <array>
#include <cstddef>
#include <cstdint>

/// What happens to the texels of charts that no frame saw.
enum class Unseen
{
    fill,   ///< The colors of the seen surface around, see fill_unseen.
    color,  ///< One color.
    keep    ///< What the texture holds there.
};

struct BakeOptions
{
    Unseen unseen;
    std::array<std::uint8_t, 3> unseen_color;
};

/// Counts of texels whose center lies in a chart.
struct BakeCounts
{
    std::size_t chart_texels = 0;
    std::size_t seen_texels = 0;
};

/// The 8-bit picture of a texture, S x S x 3: layers collapsed, unseen texels filled, the gutter filled from the nearest chart
/// texels. Equal for any number of threads. The mesh must have passed check_mesh and have texcoords. Throws Error, Canceled.
fresco::Raster8 bake(const fresco::Texture& texture, const fresco::Mesh& mesh, const BakeOptions& options, BakeCounts& counts,
                     fresco::Progress& progress);

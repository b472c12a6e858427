#pragma once

#include <fresco/parallel.h>
#include <fresco/splats/painted_splats.h>
#include <fresco/texture.h>

#include <cstddef>

/// \file The colors of a painted surface, on the Gaussians of the splat that it was made from.

namespace export_splats
{

struct PaintOptions
{
    double unit_m = 1;    ///< Meters per unit of the splat, whose axes are those of the mesh's world.
    double stroke_m = 0;  ///< Width of strokes.
    bool densify = true;  ///< Split Gaussians that would blur strokes.
    std::size_t most_parts = 30'000'000;
};

struct Painting
{
    fresco::splats::PaintedSplats splats;
    std::size_t split = 0;      ///< Gaussians of the file that became several.
    std::size_t unpainted = 0;  ///< These do not reach the surface and keep their color.
};

/// Each Gaussian takes the color of the texture where the surface is nearest to its center, averaged over its footprint; over its
/// distance from the surface where that is larger, less a stroke. Those that end farther than a stroke off the surface, three
/// standard deviations from their center, keep theirs. The order of the file is kept, and the parts of a Gaussian are together.
/// The mesh must have passed check_textured_mesh. The same for any progress.threads(). Throws Error if splitting would make too
/// many of them; Canceled.
Painting paint(const fresco::splats::Splats& splats, const fresco::TexturedMesh& textured, const PaintOptions& options,
               const fresco::Progress& progress);

/// Turns a splat and its painting by half a turn about x: programs show PLY and SPLAT with -y up, as trainers write them, SPZ and
/// GLB with +y up.
void turn_over(fresco::splats::Splats& splats, fresco::splats::PaintedSplats& painted);

}  // namespace export_splats

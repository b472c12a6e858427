#pragma once

#include "level.h"

#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/run_context.h>
#include <fresco/texture.h>

#include <cstdint>

/// \file Paints a surface from coarse to fine, and once more with finer strokes where the start has detail. paint() makes the
/// texture of the finest level. The stage calls synthesize(), which runs all levels.

namespace fresco::synthesize
{

struct Painting
{
    Texture texture;
    SourceMap source;
};

/// Makes the texture with the given texels from a finished level: the patches over each texel that a chart touches vote once
/// more, with colors of the style picture at the texture's own size (never enlarged). The texel mixes the color of the patch with
/// the largest weight (`heaviest_share`) with the mean of all, and adds the mean shift. The same for any number of threads.
/// Throws Canceled.
Painting paint(const Task& task, const Level& level, const texturing::TexelFaces& faces, Progress& progress);

/// texturing::mean_texel_m, in meters. Throws Error if charts or surface have no area.
double texel_width_m(const Mesh& mesh, int size_px);

/// Width of strokes: `wanted_m`, or if that is 0, texturing::usual_stroke_m. Throws Error if the wanted ones are narrower than
/// two texels, or wider than the surface is long.
double stroke_width_m(const Mesh& mesh, double wanted_m, double texel_m);

struct SynthesisOptions
{
    int size_px = 0;          ///< Texels per side of the texture.
    double stroke_m = 0;      ///< Width of the picture's strokes (see stroke_width_px) on the surface.
    double painterly = 0.35;  ///< 0 … 1
    double detail = 0.5;      ///< 0 … 1
    int patch_px = 11;        ///< Points along a patch, odd: a stroke's width and some of what is beside it.
    int levels_count = 2;     ///< Each has half the resolution of the next.
    int rounds_count = 3;     ///< The coarsest level takes these.
    std::uint32_t seed = 0;
    double checkpoint_seconds = 10;  ///< Maximum seconds of work that a killed run loses; 0: no checkpoints.
    double preview_seconds = 5;      ///< Between previews: often enough to watch, at a twentieth of the time.
};

/// Paints a surface from coarse to fine: strokes are 8 texels wide in the finest level and half as many in each coarser one; then
/// the texture. Levels finer than the texture are left out, so that a smaller texture is the same painting, stopped early.
/// Resumes from a checkpoint of an interrupted run, with the same result. `images`: writes previews; may be null. Throws
/// Canceled.
Painting synthesize(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run);

}  // namespace fresco::synthesize

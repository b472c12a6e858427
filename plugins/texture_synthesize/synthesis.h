#pragma once

#include "paint.h"

#include <fresco/image_io.h>
#include <fresco/run_context.h>

#include <cstdint>

namespace fresco::synthesize
{

struct SynthesisOptions
{
    int size_px;          ///< Texels per side of the texture.
    double stroke_m;      ///< How wide the picture's strokes (see stroke_width_px) are on the surface.
    double painterly;     ///< 0 … 1
    double completeness;  ///< See SearchOptions.
    int patch_px;         ///< Points along a patch, odd.
    int levels_count;     ///< Each half as fine as the next.
    int rounds_count;     ///< Per level.
    std::uint32_t seed;
    double checkpoint_seconds;  ///< Maximum seconds of work that a killed run loses; 0: no checkpoints.
    double preview_seconds;     ///< Between previews.
};

/// Paints a surface from coarse to fine: levels whose strokes are 8 texels wide and half as many, and then the texture. Levels
/// finer than the texture are left out, so that a smaller texture is the same painting, stopped early. Goes on from a checkpoint
/// of an interrupted run, with the same result. `images`: writes previews; may be null. Throws Canceled.
Painting synthesize(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run);

}  // namespace fresco::synthesize

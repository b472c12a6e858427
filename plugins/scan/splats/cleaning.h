#pragma once

#include <fresco/splats/splats.h>

#include <cstddef>

/// \file Takes out of a splat what is not surface, before the stage plans its cameras. Trained splats have faint Gaussians, giant
/// ones that paint the sky or a blur, and specks that float where no picture contradicted them.

namespace scan_splats
{

struct CleanedSplats
{
    fresco::splats::Splats splats;  ///< The others, in the file's order.
    std::size_t faint = 0;          ///< Removed: too transparent to be seen.
    std::size_t giant = 0;          ///< Removed: longer than a part of the scene.
    std::size_t far = 0;            ///< Removed: many times farther from the middle than most.
    std::size_t loose = 0;          ///< Removed: in small heaps with empty space around.
    /// Share of needles, by opacity times footprint and before loose ones are removed: a scene that was not trained to its end
    /// consists of them.
    double needle_share = 0;
    /// Half of the same are longer than this part of the distance within which nine of ten lie.
    double coarseness = 0;
};

CleanedSplats cleaned(fresco::splats::Splats splats);

}  // namespace scan_splats

#pragma once

#include "detail.h"
#include "seen_surface.h"

#include <fresco/progress.h>

#include <cstddef>
#include <string>
#include <vector>

/// \file Blur by comparison: a picture of a plain wall and a blurred picture have little detail both, but only the blurred one
/// has less than the other pictures of the same surface.

namespace fresco::sharpest
{

/// A frame as far as its blur is concerned.
struct BlurView
{
    std::string sequence;
    Detail detail;
    SeenSurface surface;
};

/// How far each picture is blurred beyond the sharper ones of its neighbors in the recording that see the same surface: the
/// length in pixels (of a picture measured_height_px high) of the line that would blur those as much, along the direction in
/// which that is longest. 0 for the sharpest, and for pictures in which no neighbor has detail to compare; at most about 11.
/// Views without a surface are compared as a whole with the two before and the two after. Deterministic. Throws Canceled.
///
/// Compares what Crete et al., "The blur effect" (2007), compare, the detail of a picture and of one that was blurred further,
/// but between frames, so that the picture's content cancels.
std::vector<double> blur_px(const std::vector<BlurView>& views, Progress& progress);

/// Of views that are about to be dropped, those that have to stay, least blurred first: each shows a piece of surface, of
/// two by two blocks, that neither a kept view nor one that has to stay before it shows. Throws Canceled.
std::vector<std::size_t> needed_views(const std::vector<BlurView>& views, const std::vector<double>& blur,
                                      const std::vector<bool>& is_kept, const Progress& progress);

}  // namespace fresco::sharpest

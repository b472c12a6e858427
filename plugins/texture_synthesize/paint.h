#pragma once

#include "level.h"

#include <fresco/source_map.h>
#include <fresco/texture.h>

namespace fresco::synthesize
{

struct Painting
{
    Texture texture;
    SourceMap source;
};

/// The texture of `size_px` texels a side that a finished level comes to: each texel that a chart touches asks the patches over
/// it once more, in the style picture at the texture's own size (never enlarged), and mixes `heaviest_share` of the one that
/// counts most with the mean of all. The same for any number of threads. Throws Canceled.
Painting paint(const Task& task, const Level& level, int size_px, Progress& progress);

}  // namespace fresco::synthesize

#pragma once

#include <fresco/image.h>

namespace fresco
{

/// Fills what is not covered from coarser and coarser means of what is (Gortler et al., "The Lumigraph", SIGGRAPH 1996,
/// section 3.4): smooth, near texels first. `picture`: W x H x C; `covered`: W x H. Covered values stay; nothing covered leaves
/// the picture as it is.
void push_pull(RasterF& picture, const Raster8& covered);

}  // namespace fresco

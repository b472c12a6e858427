#pragma once

#include "atlases.h"
#include "decimations.h"

/// \file Blender's operators, run without a window in a process of its own. Their time is only the operator's, as Blender takes
/// it: carrying the mesh over does not count.

namespace bench
{

/// Whether there is a `blender`; it is looked for once.
bool has_blender();

Decimation blender_decimation();
AtlasMaker blender_atlas();

}  // namespace bench

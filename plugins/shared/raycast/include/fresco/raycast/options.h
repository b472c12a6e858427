#pragma once

#include <fresco/option.h>

#include <string>

/// \file Options of stages that render.

namespace fresco::raycast
{

/// The option `samples`: RenderOptions::samples_per_side.
Option<int> samples_option(Configurable* owner);
/// The option `shading`, which lights_of reads.
Option<std::string> shading_option(Configurable* owner,
                                   std::string help = "Lamps: none, or those of StyleMesh's published viewer for a data set");

}  // namespace fresco::raycast

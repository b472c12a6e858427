#pragma once

#include "run/progress_display.h"

#include <memory>

namespace fresco::host
{

/// For a terminal at standard error: all stages below everything else, redrawn in place. What is drawn is written at once and
/// stays where it is: no mode of the terminal is changed and its cursor stays visible, so that there is nothing to put back,
/// however the program ends. Goes away with the object.
std::unique_ptr<ProgressDisplay> make_live_display();

}  // namespace fresco::host

#pragma once

#include "run/progress_display.h"

#include <cstdio>
#include <memory>

/// \file Shows a run at standard error: on a terminal all stages, redrawn in place, otherwise a line now and then.

namespace fresco::host
{

enum class DisplayKind
{
    live,   ///< All stages with what they do, redrawn in place.
    plain,  ///< A line at the start, every 30 s and at the end.
    quiet,  ///< Only problems.
    json    ///< One JSON object per line on standard output.
};
std::unique_ptr<ProgressDisplay> make_display(DisplayKind kind);
/// Shows a run by `display`, and writes its events to `file` as those of DisplayKind::json; the file must stay open.
std::unique_ptr<ProgressDisplay> make_recording_display(std::unique_ptr<ProgressDisplay> display, std::FILE* file);

}  // namespace fresco::host

#pragma once

#include "run/running_stage.h"

#include <string>

namespace fresco::host
{

/// "room.yaml:7:3: error: stage mesh (mesh.decimate): TEXT" and the inputs it worked on.
std::string stage_error_text(const PipelineStage& stage, const std::string& text);

/// Why a stage's process ended without a result, in words.
std::string failure_text(const RunningStage& running);
/// The host's exit code for it.
int failure_code(const RunningStage& running);

}  // namespace fresco::host

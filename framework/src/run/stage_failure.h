#pragma once

#include "run/running_stage.h"

#include <filesystem>
#include <string>

namespace fresco::host
{

/// "room.yaml:7:3: error: stage mesh (mesh.decimate): TEXT" and the inputs it worked on.
std::string stage_error_text(const PipelineStage& stage, const std::string& text);

/// Of a result that is damaged again after it was recomputed: what may do that.
std::string repeated_damage_text(const Damage& damage, const RunState& state);

/// Why a stage's process ended without a result, in words, and the command that shows all it printed, where that is more.
std::string failure_text(const RunningStage& running, const std::filesystem::path& pipeline, const std::filesystem::path& store);
/// The host's exit code for it.
int failure_code(const RunningStage& running);

}  // namespace fresco::host

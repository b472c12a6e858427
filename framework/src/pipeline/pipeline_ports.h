#pragma once

#include "pipeline/pipeline_wiring.h"

#include <string>

namespace fresco::host
{

/// Gives a stage whose options declare ports a type of its own with those ports, and reports what keeps its command lines from
/// being run. Where such an option was not understood the stage gets no type: nothing can be said of ports that are not known.
void settle_declared_ports(StageDraft& stage, TypeTable& types, ProblemList& problems);

/// What the costs of a stage are remembered by: its type, and of one that runs a program also that with its first words and
/// files.
std::string cost_name(const PipelineStage& stage);

}  // namespace fresco::host

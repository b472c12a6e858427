#pragma once

#include "pipeline/pipeline_matrix.h"
#include "pipeline/pipeline_sets.h"

#include <optional>
#include <vector>

/// \file Makes the stages of all combinations of a matrix out of the stages of the file, each only once for all combinations
/// that it is the same in. Used by load_pipeline.

namespace fresco::host
{

/// The stages and the sweep of `pipeline`, of all chosen combinations or of `part`. Every problem is reported once; one that not
/// all combinations have says which values they have in common. With problems there are no stages.
void load_stages(const PipelineDocument& document, const std::vector<MatrixAxis>& matrix, const std::optional<SweepPart>& part,
                 const Settings& settings, TypeTable& types, Pipeline& pipeline, ProblemList& problems);

}  // namespace fresco::host

#pragma once

#include "pipeline/pipeline_matrix.h"
#include "pipeline/pipeline_sets.h"

#include <optional>
#include <vector>

/// \file Makes the stages of all combinations of a matrix out of the stages of the file, each only once for all combinations
/// that it is the same in. Used by load_pipeline.

namespace fresco::host
{

/// The stages and the sweep of `pipeline`, of all chosen combinations. Every problem is reported once; one that not
/// all combinations have says which values they have in common. With problems there are no stages. `missing`: what
/// combinations lack that are left out because others lack nothing; null: none is left out.
void load_stages(const PipelineDocument& document, const std::vector<MatrixAxis>& matrix, const Settings& settings,
                 TypeTable& types, Pipeline& pipeline, ProblemList& problems, ProblemList* missing = nullptr);

}  // namespace fresco::host

#pragma once

#include "pipeline/pipeline.h"
#include "store/statistics.h"

#include <map>
#include <string>
#include <vector>

namespace fresco::host
{

struct PipelineEstimate
{
    std::map<std::string, CostFigures> stages;  ///< By name.
    /// "mesh: 1000000 faces assumed: no input says how many", once for all of a matrix's stages of the name.
    std::vector<std::string> notes;
};

/// What the stages of a pipeline cost by their own account, before anything was measured. Sizes are carried along the wires: one
/// of frames carries frames, one of a mesh faces, any other all. Opens no file; looks at names and sizes of input files.
PipelineEstimate estimate_pipeline(const Pipeline& pipeline, int cores);

}  // namespace fresco::host

#pragma once

#include <fresco/cost.h>
#include <fresco/host/pipeline.h>
#include <fresco/host/statistics.h>

#include <map>
#include <string>
#include <vector>

namespace fresco::host
{

/// A cost as the entry `cost` of TypeDescription::declaration; `options` is the entry beside it. Throws Error naming the
/// type where it names an option that is not there or is of the wrong kind, and where a number is negative or not finite.
Value describe_cost(const std::string& type, const Cost& cost, const Value& options);

struct PipelineEstimate
{
    std::map<std::string, CostFigures> stages;  ///< By name.
    std::vector<std::string> notes;             ///< "mesh: 1000000 faces assumed: no input says how many"
};

/// What the stages of a pipeline cost by their own account, before anything was measured. Sizes are carried along the wires: one
/// of frames carries frames, one of a mesh faces, any other all. Opens no file; looks at names and sizes of input files.
PipelineEstimate estimate_pipeline(const Pipeline& pipeline, int cores);

}  // namespace fresco::host

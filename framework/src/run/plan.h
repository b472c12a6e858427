#pragma once

#include "pipeline/pipeline.h"
#include "run/run_state.h"
#include "store/statistics.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// \file What would run, why, and what it costs. `fresco plan` prints it, and the scheduler goes by its costs.

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

struct PlannedStage
{
    std::string stage;
    std::string type;
    bool runs = false;
    std::string reason;             ///< Why it runs, or why it does not.
    CostFigures cost;               ///< Of running it.
    bool measured = false;          ///< `cost` is corrected by earlier runs on this machine.
    std::size_t files_to_copy = 0;  ///< Of a stored result, those that are missing or different below `out`.
};

struct Plan
{
    std::vector<PlannedStage> stages;
    std::vector<std::string> obstacles;  ///< Files for which the run would stop, see Exporter.
    CostFigures total;                   ///< Seconds and disk: sums over stages that run; memory: the largest.
};

/// What a run would do, with its files below `out`. `estimates`: per stage, see estimate_pipeline. `upstream`: the store that
/// lends results; empty: none. Changes nothing but remembered file stamps.
Plan make_plan(const Pipeline& pipeline, const std::filesystem::path& store, const std::filesystem::path& out,
               const std::string& until, const std::map<std::string, CostFigures>& estimates,
               const std::filesystem::path& upstream = {}, bool replace = false);

}  // namespace fresco::host

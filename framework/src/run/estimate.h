#pragma once

#include "pipeline/pipeline.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fresco::host
{

/// What a stage took in an earlier run on this machine.
struct MeasuredCost
{
    std::optional<double> seconds;
    std::optional<double> memory_mb;
    std::optional<double> disk_mb;
    std::optional<double> frames;  ///< Of what it made, where known.
    std::optional<double> faces;
};

struct StageEstimate
{
    std::string stage;
    std::optional<double> seconds;  ///< Nothing where the plugin's formula cannot be computed; `notes` says why.
    std::optional<double> memory_mb;
    std::optional<double> disk_mb;
    std::optional<double> frames;  ///< Passed on to the stages behind it.
    std::optional<double> faces;
    bool measured = false;                 ///< `seconds` is from an earlier run.
    std::optional<double> height_squares;  ///< Of the uv maps it made, passed on too.

    /// What was assumed ("300 frames assumed: …") and which formulas do not work, ready to be shown.
    std::vector<std::string> notes;
};

struct PipelineEstimate
{
    std::vector<StageEstimate> stages;  ///< In the pipeline's order.
    double seconds = 0;                 ///< One stage after the other.
    double memory_mb = 0;               ///< Of the largest stage.
    double disk_mb = 0;                 ///< All results together.
    bool complete = true;               ///< False: some figure is missing in the sums.
};

inline constexpr double assumed_frames = 300;
inline constexpr double assumed_faces = 1e6;

/// What a pipeline will about cost, from the stages' formulas (fresco/stage.h, Cost) and, going before them, what earlier runs
/// measured (by stage name). Frames and faces are carried along the wires: a wire of frames carries frames, one of a mesh faces,
/// any other both. In a formula they are the inputs' figures, or, for a stage without any, its own. Opens no file; looks at
/// names and sizes of input files.
PipelineEstimate estimate_pipeline(const Pipeline& pipeline, int cores, const std::map<std::string, MeasuredCost>& measured = {});

}  // namespace fresco::host

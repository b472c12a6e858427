#pragma once

/// \file The optimization as a function: the stage above it only reads options.

#include "initial_texture.h"
#include "pictures.h"
#include "schedule.h"
#include "views.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/run_context.h>
#include <fresco/texture.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/optimizer_rule.h>
#include <fresco/torch/texture_representation.h>
#include <fresco/uv_maps.h>

#include <torch/types.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fresco::optimize
{

struct LoopInputs
{
    const UvMaps& maps;
    const Frames& frames;
    const Raster8& style;
    const Texture* start = nullptr;  ///< Start of `init: frames`, instead of gathering one.
};

struct LoopComponents
{
    const std::map<std::string, std::shared_ptr<Loss>>& losses;
    TextureRepresentation& texture;
    OptimizerRule& rule;
    const ImageIo* images = nullptr;  ///< Null: only NPY pictures, no previews.
};

struct LoopOptions
{
    int size_px = 0;
    std::vector<int> heights_px = {};  ///< Empty = all.
    Values values = Values::display;
    Init init = Init::frames;
    LevelRules levels = {};
    double lambda_r = 0;
    std::uint64_t seed = 0;
    torch::Device device = torch::kCPU;
    ScheduleOptions schedule = {};
    // Measuring on views that are not optimized for
    int held_out_count = 0;
    std::int64_t measure_steps = 40;  ///< Often enough to stop a run of some hundred steps, at a tenth of its time.
    double stop_gain = 0;             ///< 0 = all steps are made.
    std::int64_t stop_at_step = 0;    ///< Ends after this step, with all rates as they are without it; 0 = all steps.
    // How it is run
    std::int64_t checkpoint_steps = 0;  ///< 0 = none. A run whose loss is not finite goes back to one.
    double checkpoint_seconds = 30;     ///< Work that a killed run may lose; 0 = all of it. Of no effect on results.
    double preview_seconds = 10;        ///< Between previews, or twenty times what one takes; 0 = none.
};

/// Optimizes a texture until every view, rendered with it, is what the losses want. Goes on from the checkpoint in
/// run.checkpoint_folder(), if there is one, and ends with the same bytes as a run without interruption; on the CPU they are the
/// same for any number of threads. Where a loss is not finite, the run goes back to its last checkpoint and halves the rate,
/// three times at most. Throws Error for inputs that do not fit and for a loss that still is not finite.
Texture optimized_texture(const LoopInputs& inputs, const LoopComponents& components, const LoopOptions& options,
                          RunContext& run);

}  // namespace fresco::optimize

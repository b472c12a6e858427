#pragma once

#include "loop.h"

namespace fresco::optimize
{

/// Every pixel at every height, at any angle.
inline constexpr LevelRules all_pixels{.protocol = Protocol::paper,
                                       .by_depth = false,
                                       .depth = LevelRules::Depth::mesh,
                                       .theta_d_m = 0.25,
                                       .angle_limit_deg = 90,
                                       .scaling = GradientScaling::angle};

/// Steps over all views in their whole size, neither measured nor kept, from zeros.
inline LoopOptions short_loop(int size_px, int repeats_count, const torch::Device& device = torch::kCPU)
{
    return {.size_px = size_px,
            .heights_px = {},
            .values = Values::display,
            .init = Init::zeros,
            .levels = all_pixels,
            .lambda_r = 0,
            .seed = 0,
            .device = device,
            .schedule = {.epochs = 1,
                         .repeats_count = repeats_count,
                         .max_steps = 0,
                         .shuffled = true,
                         .rate = 0.02,
                         .decay = Decay::cosine,
                         .decay_start = 0.5,
                         .step_epochs = 3,
                         .step_factor = 0.1},
            .held_out_count = 0,
            .measure_steps = 50,
            .stop_gain = 0,
            .reference = false,
            .checkpoint_steps = 0,
            .checkpoint_seconds = 0,
            .preview_every = 0};
}

}  // namespace fresco::optimize

#pragma once

#include "loop.h"

namespace fresco::optimize
{

/// Every pixel at every height, at any angle.
inline constexpr LevelRules all_pixels{.by_depth = false,
                                       .depth = LevelRules::Depth::mesh,
                                       .depth_rule = {.theta_min_px = 32, .theta_d_m = 0.25, .printed_weight = false},
                                       .angle = {.limit_deg = 90, .below = false, .from_smallest = false},
                                       .scaling = GradientScaling::angle,
                                       .share_by_features = false,
                                       .enlarge_camera_features = false,
                                       .fill_with_corner = false};

/// Steps over all views in their whole size, neither measured nor kept, from zeros.
inline LoopOptions short_loop(int size_px, int repeats_count, const torch::Device& device = torch::kCPU)
{
    return {.size_px = size_px,
            .heights_px = {},
            .values = "display",
            .clamp_layers = false,
            .init = "zeros",
            .levels = all_pixels,
            .style_rule = StyleRule::printed,
            .lambda_r = 0,
            .seed = 0,
            .device = device,
            .train_share = 1,
            .schedule = {.epochs = 1,
                         .repeats_count = repeats_count,
                         .max_steps = 0,
                         .shuffled = true,
                         .rate = 0.02,
                         .cosine = true,
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

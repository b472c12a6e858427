#pragma once

#include "view_data.h"

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

}  // namespace fresco::optimize

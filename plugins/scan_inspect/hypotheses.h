#pragma once

#include "agreement.h"

#include <string>
#include <vector>

namespace fresco::inspect
{

/// Mistakes of one kind, all variants of which are tried.
struct Hypothesis
{
    std::string name;
    std::vector<Assumption> variants;
    bool any_depth_scale = false;  ///< Each variant is judged with the depth scale that suits it best.
    double advantage = 0.01;       ///< By how much it must beat the hypotheses before it in the table.
};

/// How far and how finely continuous mistakes are looked for.
inline constexpr double focal_reach = 0.36;  ///< Natural logarithm.
inline constexpr double lag_reach = 4;       ///< Frames; tracks reach further by one.

/// What a recording that partly agrees may suffer from, likely mistakes first, each on top of what is assumed already: another
/// depth unit, the color camera's intrinsics, pictures that are upside down, distances along rays, intrinsics of another size,
/// focal lengths, poses of other times, another unit of the poses.
std::vector<Hypothesis> small_hypotheses(const Assumption& assumed, const std::vector<DepthView>& views);

/// Those that leave nothing where it was: axes, inverted poses, units, a turned or mirrored mesh, quaternions, transposed
/// rotations. `reach`: how many times farther from the origin than from what they see cameras are; large ones need finer steps of
/// scale.
std::vector<Hypothesis> large_hypotheses(double reach);

/// The likeliest of both, for recordings without depth, where each one costs more.
std::vector<Hypothesis> common_hypotheses(const std::vector<DepthView>& views);

/// Whether the depth pictures' camera has the same rays as the color pictures'.
bool one_camera(const DepthView& view);

}  // namespace fresco::inspect

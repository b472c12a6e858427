#pragma once

#include <fresco/inspection/agreement.h>

#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>

#include <cstddef>
#include <vector>

/// \file Searches for the mistakes that explain why measured depths and mesh disagree: casts rays under some 1,300 hypotheses,
/// refines the promising ones and keeps those that the depths need. The diagnosis uses it, and tries the most likely hypotheses
/// itself on recordings without depth.

namespace fresco::inspect
{

/// Mistakes of one kind, all variants of which are tried.
struct Hypothesis
{
    std::vector<Assumption> variants;
    bool any_depth_scale = false;  ///< Each variant is judged with the depth scale that suits it best.
    double advantage = 0.01;       ///< By how much it must beat the hypotheses before it in the table.
};

/// Continuous mistakes are searched up to these limits.
inline constexpr double focal_reach = 0.75;  ///< Natural logarithm.

/// The most likely mistakes, for recordings without depth, where each hypothesis costs more.
std::vector<Hypothesis> common_hypotheses();

/// The mistakes that explain the measured depths clearly better than the recorded values (see explains()), or the default: the
/// best hypothesis, and up to two more on top of it. A mistake that the others make superfluous is dropped. The same for any
/// number of threads. Throws Canceled.
/// Without a scene, views are compared with each other.
Assumption explain_depths(const raycast::Scene* scene, const std::vector<DepthView>& views, const Progress& progress);

}  // namespace fresco::inspect

#pragma once

#include "agreement.h"

namespace fresco::inspect
{

/// By how much the mesh seems moved against the frames: a rotation and a shift that bring measured points onto the faces that
/// their rays meet (point to plane; Chen and Medioni, "Object modelling by registration of multiple range images", 1992),
/// starting at assumption.move. For moves of some decimeters. Uses every `stride`-th sample. Single-threaded.
RigidTransform best_move(const raycast::Scene& scene, const std::vector<DepthView>& views, const Assumption& assumption,
                         std::size_t stride);

}  // namespace fresco::inspect

#pragma once

#include "search.h"

#include <span>
#include <vector>

namespace fresco::synthesize
{

/// How much each key's distances count: 1 / (α + the least distance of any of `queries`), so that a part of the picture that
/// nothing looks like is worth more (completeness; Granot et al. 2022). `queries`: n x feature_count(). Throws Cancelled.
std::vector<float> completeness_weights(const PictureLevel& picture, std::span<const float> queries, double alpha,
                                        const Progress& progress);

/// Raises the weights where the picture was used more than twice as much as on average, over squares of 1 % of its area.
void weigh_crowds(const PictureLevel& picture, std::span<const Match> matches, std::vector<float>& weights);

}  // namespace fresco::synthesize

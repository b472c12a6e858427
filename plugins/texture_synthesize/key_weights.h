#pragma once

#include "search.h"

#include <span>
#include <vector>

namespace fresco::synthesize
{

/// How much each key's distances count: 1 / (α + the least distance of any of `queries`), so that a part of the picture that
/// nothing looks like is worth more (completeness; Granot et al. 2022). `queries`: n x feature_count(). Throws Canceled.
std::vector<float> completeness_weights(const PictureLevel& picture, std::span<const float> queries, double alpha,
                                        const Progress& progress);

/// Raises each key's factor (at least 1) while the picture is used there more than three times the average, over squares of 1 %
/// of its area, and lowers it again below that: a price that settles over the rounds.
void update_crowding(const PictureLevel& picture, std::span<const Match> matches, std::vector<float>& crowding);

}  // namespace fresco::synthesize

#pragma once

#include "agreement.h"

#include <vector>

namespace fresco::inspect
{

/// Shares of recordings that are right lie above this, noise, holes and missing parts of the mesh included.
inline constexpr double good_share = 0.7;

/// Whether `assumed` explains the recording, and what was recorded does not: enough depths are covered, in enough frames; most of
/// those agree; at least half of the disagreement is gone; no fewer depths agree than before; and the gain is more than chance
/// over frames (bootstrap). Or it agrees as well and explains several times as many depths. Both hold the same frames.
bool explains(const std::vector<Agreement>& recorded, const std::vector<Agreement>& assumed);

/// Whether the depths agree: a good share of those that are covered, or most of those that the mesh is not merely behind of,
/// where it lacks what stands before it.
bool fits(const Agreement& sum);

/// Whether `after` is a step in the right direction, where several mistakes are made at once.
bool improves(const std::vector<Agreement>& before, const std::vector<Agreement>& after);

/// Whether a mean over frames of `after` - `before` is more than chance.
bool gains(const std::vector<double>& before, const std::vector<double>& after);

}  // namespace fresco::inspect

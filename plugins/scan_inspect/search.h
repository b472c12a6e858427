#pragma once

#include "agreement.h"

#include <fresco/progress.h>

#include <vector>

namespace fresco::inspect
{

/// An assumption and how the frames agree with the mesh under it.
struct Judged
{
    Assumption assumption;
    std::vector<Agreement> frames;
};

/// All samples under an assumption.
Judged judge(const raycast::Scene& scene, const std::vector<DepthView>& views, const Assumption& assumption);

/// The mistakes that explain the measured depths clearly better than what was recorded (see explains()), or the recorded state:
/// the best of the table of hypotheses, and up to two more on top of it. None is kept that another one makes superfluous.
/// The same for any number of threads. Throws Canceled.
Judged explain_depths(const raycast::Scene& scene, const std::vector<DepthView>& views, const Progress& progress);

}  // namespace fresco::inspect

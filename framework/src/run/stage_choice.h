#pragma once

#include "run/run_state.h"
#include "run/stage_costs.h"

#include <vector>

namespace fresco::host
{

/// What running stages leave of the machine.
struct Room
{
    int cores = 1;
    double memory_mb = 0;  ///< At most so much together; 0: no limit.
    double taken_mb = 0;
    bool idle = true;  ///< No stage is running.

    void take(int threads, double more_mb);
};

struct Start
{
    StageNode* node = nullptr;
    int threads = 1;
};

/// Which of the stages that may begin start now: the first that fit the memory, as many as there are cores, which they share
/// evenly. One may always run. `may_begin`: by place, whose turn it is.
std::vector<Start> choose_starts(RunState& state, const std::vector<bool>& may_begin, StageCosts& costs, Room room);

}  // namespace fresco::host

#include "run/stage_choice.h"

#include <algorithm>

namespace fresco::host
{

void Room::take(int threads, double more_mb)
{
    cores -= threads;
    taken_mb += more_mb;
    idle = false;
}

std::vector<Start> choose_starts(RunState& state, const std::vector<bool>& may_begin, StageCosts& costs, Room room)
{
    std::vector<Start> starts;
    int free = room.cores;
    for (const std::size_t place : state.ready())
    {
        if (room.cores <= 0)
            break;
        StageNode& node = state.nodes()[place];
        const double more_mb = costs.expected(node).memory_mb;
        const bool fits = room.idle || room.memory_mb <= 0 || room.taken_mb + more_mb <= room.memory_mb;
        if (!may_begin[place] || !fits)
            continue;
        room.take(1, more_mb);
        starts.push_back({&node});
    }
    int left = static_cast<int>(starts.size());
    for (Start& start : starts)
    {
        start.threads = std::max(1, free / left);
        free -= start.threads;
        --left;
    }
    return starts;
}

}  // namespace fresco::host

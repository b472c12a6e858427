#include "frame_pairs.h"

#include <map>
#include <utility>

namespace
{
std::vector<FramePair> by_number(const std::vector<FramePlace>& frames, long gap)
{
    std::map<std::pair<std::string, long>, std::size_t> places;
    for (std::size_t i = 0; i < frames.size(); ++i)
        places.emplace(std::pair(frames[i].sequence, frames[i].number), i);
    std::vector<FramePair> pairs;
    for (std::size_t i = 0; i < frames.size(); ++i)
        if (const auto target = places.find({frames[i].sequence, frames[i].number + gap}); target != places.end())
            pairs.push_back({i, target->second});
    return pairs;
}

std::vector<FramePair> by_position(const std::vector<FramePlace>& frames, std::size_t gap)
{
    std::map<std::string, std::vector<std::size_t>> sequences;
    std::vector<std::size_t> position(frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
        auto& sequence = sequences[frames[i].sequence];
        position[i] = sequence.size();
        sequence.push_back(i);
    }
    std::vector<FramePair> pairs;
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
        const auto& sequence = sequences[frames[i].sequence];
        if (position[i] >= gap)
            pairs.push_back({i, sequence[position[i] - gap]});
        else if (position[i] + gap < sequence.size())
            pairs.push_back({i, sequence[position[i] + gap]});
    }
    return pairs;
}
}  // namespace

std::vector<FramePair> frame_pairs(const std::vector<FramePlace>& frames, long gap, Protocol protocol)
{
    return protocol == Protocol::paper ? by_number(frames, gap) : by_position(frames, static_cast<std::size_t>(gap));
}

long smallest_gap(const std::vector<FramePlace>& frames)
{
    std::map<std::string, std::map<long, bool>> numbers;
    for (const FramePlace& frame : frames)
        numbers[frame.sequence][frame.number] = true;
    long smallest = 0;
    for (const auto& [sequence, list] : numbers)
        for (auto next = list.begin(); next != list.end();)
            if (const long number = (next++)->first; next != list.end() && (smallest == 0 || next->first - number < smallest))
                smallest = next->first - number;
    return smallest;
}

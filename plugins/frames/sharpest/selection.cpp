#include "selection.h"

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <numeric>
#include <span>

namespace
{

/// One decimal, rounded down, so that the frame it is from passes.
std::string threshold_text(double sharpness)
{
    return fmt::format("{:.1f}", std::floor(sharpness * 10) / 10);
}

[[noreturn]] void refuse_all_blurred(const std::vector<MeasuredFrame>& frames, double min_sharpness)
{
    auto sorted = frames;
    std::ranges::sort(sorted, std::greater(), &MeasuredFrame::sharpness);
    const auto& best = sorted.front();
    throw fresco::Error(fmt::format(
        "none of the {} frames passes min_sharpness {}: the sharpest, {}/{}, has {}; min_sharpness: {} would keep half of them",
        frames.size(), threshold_text(min_sharpness), best.sequence, best.name, threshold_text(best.sharpness),
        threshold_text(sorted[(sorted.size() - 1) / 2].sharpness)));
}

/// The first of equal ones.
std::size_t sharpest(const std::vector<MeasuredFrame>& frames, std::span<const std::size_t> among)
{
    return *std::ranges::max_element(among, {}, [&](std::size_t i) { return frames[i].sharpness; });
}

/// Windows start over with each sequence: two sequences may show different rooms.
std::vector<std::size_t> sharpest_of_windows(const std::vector<MeasuredFrame>& frames, std::size_t window)
{
    std::vector<std::size_t> all(frames.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    std::vector<std::size_t> kept;
    for (std::size_t begin = 0; begin < frames.size();)
    {
        std::size_t end = begin + 1;
        while (end < frames.size() && end - begin < window && frames[end].sequence == frames[begin].sequence)
            ++end;
        kept.push_back(sharpest(frames, std::span(all).subspan(begin, end - begin)));
        begin = end;
    }
    return kept;
}

std::vector<std::size_t> sharpest_of_stretches(const std::vector<MeasuredFrame>& frames, std::span<const std::size_t> among,
                                               std::size_t stretches)
{
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < stretches; ++i)
    {
        const std::size_t begin = among.size() * i / stretches;
        kept.push_back(sharpest(frames, among.subspan(begin, among.size() * (i + 1) / stretches - begin)));
    }
    return kept;
}

}  // namespace

Selection select_frames(const std::vector<MeasuredFrame>& frames, const SelectionOptions& options)
{
    if (frames.empty())
        throw fresco::Error("port 'frames' has no frames: check the scan's path and the stages that drop frames");
    Selection selection;
    for (std::size_t i = 0; i < frames.size(); ++i)
        selection.blurred += passes(frames[i], options.min_sharpness) ? 0 : 1;
    if (selection.blurred == frames.size())
        refuse_all_blurred(frames, options.min_sharpness);

    for (const auto i : sharpest_of_windows(frames, static_cast<std::size_t>(options.window_count)))
        if (passes(frames[i], options.min_sharpness))
            selection.kept.push_back(i);
    selection.less_sharp = frames.size() - selection.blurred - selection.kept.size();

    const auto limit = static_cast<std::size_t>(options.max_frames);
    if (limit != 0 && selection.kept.size() > limit)
    {
        selection.beyond_limit = selection.kept.size() - limit;
        selection.kept = sharpest_of_stretches(frames, selection.kept, limit);
    }
    return selection;
}

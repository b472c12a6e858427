#include "verdict.h"

#include <fresco/evaluation/statistics.h>

#include <algorithm>
#include <span>

namespace fresco::inspect
{
namespace
{

constexpr evaluation::Bootstrap bootstrap{.resamples = 400, .seed = 1};
constexpr double fewest_depths = 100;
constexpr double fewest_depths_of_frame = 8;
constexpr std::size_t fewest_frames = 3;
constexpr double explained_share = 0.6;
constexpr double left_of_disagreement = 0.5;
constexpr double least_step_share = 0.25;
constexpr double left_by_step = 0.85;
constexpr double far_more = 2.5;
constexpr double more_by_chance = 1.25;
constexpr double similar_share = 0.05;
/// Of a mesh that lacks what stands before it.
constexpr double share_of_right = 0.3;
constexpr double clear_share = 0.85;

Agreement sum_of(const std::vector<Agreement>& frames, std::span<const std::size_t> chosen)
{
    Agreement sum;
    for (const std::size_t i : chosen)
        sum += frames[i];
    return sum;
}

/// The low end of the 95 % interval of the gain in share over frames.
double least_gain(const std::vector<Agreement>& before, const std::vector<Agreement>& after)
{
    const auto gain = [&](std::span<const std::size_t> chosen)
    { return sum_of(after, chosen).share() - sum_of(before, chosen).share(); };
    return evaluation::bootstrap_interval(before.size(), gain, bootstrap).low;
}

/// Too few frames have no interval: then nearly all must agree, and have disagreed.
bool beyond_chance(const std::vector<Agreement>& before, const std::vector<Agreement>& after)
{
    const auto telling =
        std::ranges::count_if(after, [](const Agreement& frame) { return frame.covered() >= fewest_depths_of_frame; });
    if (static_cast<std::size_t>(telling) < fewest_frames)
        return total(before).share() < 0.3 && total(after).share() > 0.8;
    return least_gain(before, after) > 0;
}

bool gains_most(const std::vector<Agreement>& before, const std::vector<Agreement>& after, double share, double left)
{
    const Agreement was = total(before);
    const Agreement is = total(after);
    return is.covered() >= fewest_depths && is.share() >= share && 1 - is.share() <= left * (1 - was.share()) &&
           is.agreeing >= was.agreeing && beyond_chance(before, after);
}

/// A small part may agree as recorded because a wall is where another one should be.
bool covers_more(const std::vector<Agreement>& before, const std::vector<Agreement>& after)
{
    const Agreement was = total(before);
    const Agreement is = total(after);
    const auto more = [&](std::span<const std::size_t> chosen)
    { return sum_of(after, chosen).agreeing - more_by_chance * sum_of(before, chosen).agreeing; };
    return is.covered() >= fewest_depths && is.agreeing >= far_more * was.agreeing && is.share() >= was.share() - similar_share &&
           before.size() >= fewest_frames && evaluation::bootstrap_interval(before.size(), more, bootstrap).low > 0;
}

}  // namespace

bool explains(const std::vector<Agreement>& recorded, const std::vector<Agreement>& assumed)
{
    return gains_most(recorded, assumed, explained_share, left_of_disagreement) ||
           (total(assumed).share() >= good_share && covers_more(recorded, assumed));
}

bool improves(const std::vector<Agreement>& before, const std::vector<Agreement>& after)
{
    return gains_most(before, after, least_step_share, left_by_step) || covers_more(before, after);
}

bool fits(const Agreement& sum)
{
    const double not_behind = sum.agreeing + sum.in_front;
    return sum.share() >= good_share ||
           (sum.agreeing >= share_of_right * sum.covered() && sum.agreeing >= clear_share * not_behind && not_behind > 0);
}

bool gains(const std::vector<double>& before, const std::vector<double>& after)
{
    std::vector<double> difference;
    for (std::size_t i = 0; i < before.size(); ++i)
        difference.push_back(after[i] - before[i]);
    return evaluation::bootstrap_mean(difference, bootstrap).low > 0;
}

}  // namespace fresco::inspect

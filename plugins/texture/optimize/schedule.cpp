#include "schedule.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace fresco::optimize
{
namespace
{

/// The stride next to count / golden ratio that visits everything.
std::size_t golden_stride(std::size_t count)
{
    const auto ideal = static_cast<std::size_t>(std::lround(static_cast<double>(count) / std::numbers::phi));
    for (std::size_t distance = 0;; ++distance)
    {
        if (std::gcd(ideal + distance, count) == 1)
            return ideal + distance;
        if (distance < ideal && std::gcd(ideal - distance, count) == 1)
            return ideal - distance;
    }
}

}  // namespace

std::size_t spread_index(std::size_t position, std::size_t count, std::uint64_t seed)
{
    const std::uint64_t number = mixed(seed);
    const std::size_t stride = golden_stride(count) % count;
    const std::size_t walked = (position % count) * stride % count;
    const std::size_t start = static_cast<std::size_t>(number >> 1U) % count;
    return (number & 1U) != 0 ? (start + walked) % count : (start + count - walked) % count;
}

Schedule::Schedule(std::vector<std::size_t> views, std::uint64_t seed, const ScheduleOptions& options)
    : views_(std::move(views)), seed_(seed), options_(options)
{
    steps_ = static_cast<std::int64_t>(views_.size()) * options_.epochs * options_.repeats_count;
    if (options_.max_steps > 0)
        steps_ = std::min(steps_, options_.max_steps);
}

std::size_t Schedule::visits() const
{
    return static_cast<std::size_t>((steps_ + options_.repeats_count - 1) / options_.repeats_count);
}

std::size_t Schedule::view_of_visit(std::size_t visit) const
{
    const std::size_t count = views_.size();
    const std::size_t position = visit % count;
    if (!options_.shuffled)
        return views_[position];
    return views_[spread_index(position, count, mixed(seed_, visit / count, 1))];
}

ScheduledStep Schedule::at(std::int64_t step) const
{
    ScheduledStep result;
    result.visit = static_cast<std::size_t>(step / options_.repeats_count);
    result.view = view_of_visit(result.visit);
    result.repeat = step % options_.repeats_count;
    result.epoch = static_cast<std::int64_t>(result.visit / views_.size());
    return result;
}

double Schedule::rate(std::int64_t step) const
{
    if (options_.decay == Decay::step)
        return options_.rate * std::pow(0.1, static_cast<double>(at(step).epoch / 3));
    const double begin = options_.decay_start * static_cast<double>(steps_);
    const double length = static_cast<double>(steps_) - begin;
    const double done = static_cast<double>(step) - begin;
    return done <= 0 || length <= 0 ? options_.rate : options_.rate * 0.5 * (1 + std::cos(std::numbers::pi * done / length));
}

}  // namespace fresco::optimize

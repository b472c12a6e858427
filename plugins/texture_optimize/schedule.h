#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fresco::optimize
{

struct ScheduleOptions
{
    std::vector<std::size_t> views;  ///< The views to visit, in recorded order; not empty.
    int epochs = 1;                  ///< Number of visits to every view.
    int repeats = 1;                 ///< Consecutive steps of a visit.
    std::int64_t max_steps = 0;      ///< 0 = no limit.
    bool shuffled = true;
    std::uint64_t seed = 0;
    double rate = 1;
    bool cosine = true;
    double decay_start = 0.5;  ///< Cosine: the share of the steps at the full rate.
    int step_epochs = 3;       ///< Steps: the rate is multiplied by step_factor every so many epochs.
    double step_factor = 0.1;
};

/// What happens in a step.
struct ScheduledStep
{
    std::size_t visit = 0;  ///< Counted from 0 over the run; a visit is `repeats` steps on one view.
    std::size_t view = 0;
    std::int64_t repeat = 0;  ///< Within the visit.
    std::int64_t epoch = 0;
};

/// Which view each step sees, and at which learning rate. Depends on the options alone. Thread-safe.
class Schedule
{
  public:
    explicit Schedule(ScheduleOptions options);

    std::int64_t steps() const { return steps_; }
    std::size_t visits() const;
    ScheduledStep at(std::int64_t step) const;
    std::size_t view_of_visit(std::size_t visit) const;
    double rate(std::int64_t step) const;

  private:
    ScheduleOptions options_;
    std::int64_t steps_ = 0;
};

/// The place in an epoch's order of n views: position -> index, a walk round the ring of views by the golden ratio from a seeded
/// start in a seeded direction. Neighbors in time look at different places, and every beginning of the walk covers the recording
/// evenly.
std::size_t spread_index(std::size_t position, std::size_t count, std::uint64_t seed);

}  // namespace fresco::optimize

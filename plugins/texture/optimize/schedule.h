#pragma once

/// \file Which view a step sees, and at which learning rate; computed, not stored, so that a run goes on anywhere.

#include <fresco/random.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fresco::optimize
{

/// A number that depends on all of `x`: the first one drawn with it as the seed.
inline std::uint64_t mixed(std::uint64_t x)
{
    return Random(x).bits();
}

/// A number that depends on all three.
inline std::uint64_t mixed(std::uint64_t seed, std::uint64_t a, std::uint64_t b)
{
    return mixed(mixed(mixed(seed) ^ a) ^ b);
}

/// How the learning rate falls.
enum class Decay
{
    cosine,  ///< Full for decay_start, then down to 0.
    step     ///< A tenth after every three epochs, as in StyleMesh.
};

struct ScheduleOptions
{
    int epochs = 1;              ///< Number of visits to every view.
    int repeats_count = 1;       ///< Consecutive steps of a visit.
    std::int64_t max_steps = 0;  ///< 0 = no limit.
    bool shuffled = true;
    double rate = 0.02;
    Decay decay = Decay::cosine;
    double decay_start = 0.5;  ///< Cosine: the share of the steps at the full rate.
};

/// Actions of a step.
struct ScheduledStep
{
    std::size_t visit = 0;  ///< Counted from 0 over the run; a visit is `repeats_count` steps on one view.
    std::size_t view = 0;
    std::int64_t repeat = 0;  ///< Within the visit.
    std::int64_t epoch = 0;
};

/// View and learning rate of each step. Thread-safe.
class Schedule
{
  public:
    /// `views`: those to visit, in recorded order; not empty. `seed`: of their order where it is shuffled.
    Schedule(std::vector<std::size_t> views, std::uint64_t seed, const ScheduleOptions& options);

    std::int64_t steps() const { return steps_; }
    std::size_t visits() const;
    ScheduledStep at(std::int64_t step) const;
    std::size_t view_of_visit(std::size_t visit) const;
    double rate(std::int64_t step) const;

  private:
    std::vector<std::size_t> views_;
    std::uint64_t seed_;
    ScheduleOptions options_;
    std::int64_t steps_ = 0;
};

/// The place in an epoch's order of n views: position -> index, a walk round the ring of views by the golden ratio from a seeded
/// start in a seeded direction. Neighbors in time look at different places, and every beginning of the walk covers the recording
/// evenly.
std::size_t spread_index(std::size_t position, std::size_t count, std::uint64_t seed);

}  // namespace fresco::optimize

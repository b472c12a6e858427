#pragma once

#include "moments.h"

#include <fresco/torch/loss.h>

#include <cstdint>
#include <deque>
#include <map>
#include <string>

namespace gram
{

/// The mean of the moments of the last visits to views, kept apart by name (level, layer, pixels). Consecutive steps on one view
/// are one visit, of which the last step counts.
class ViewAverage
{
  public:
    /// `count` >= 1 visits, the current one among them.
    explicit ViewAverage(int count) : count_(count) {}

    /// Where in the run a step is.
    struct Visit
    {
        std::int64_t step = 0;
        std::int64_t view = 0;
        std::int64_t repeat = 0;
    };

    /// The mean of `current` and of the up to `count` - 1 visits before it, as `current` in type and device. Gradients flow
    /// only through `current`. Remembers `current`; a second call for the same step replaces the first.
    Moments average(const std::string& name, const Visit& visit, const Moments& current);

    fresco::TensorMap state() const;
    /// Throws Error for a state that state() did not make.
    void restore(const fresco::TensorMap& state);

  private:
    struct Kept
    {
        std::int64_t step = 0;
        std::int64_t view = 0;
        Moments moments;
    };

    int count_;
    std::map<std::string, std::deque<Kept>> kept_;  ///< Oldest first; the newest is the current visit's.
};

}  // namespace gram

#pragma once

#include <fresco/value.h>

#include <functional>
#include <string>

namespace bench
{

/// Seconds that a piece of work took.
struct Times
{
    double wall = 0;
    double processor = 0;  ///< All threads together; other programs on the machine do not count.
};

/// Times pieces of work inside a case.
class Measure
{
  public:
    /// Calls `work` `times` times and returns the smallest times of a call. The first time that a Measure is used it also learns
    /// how far the process grew at its peak meanwhile.
    Times times(int times, const std::function<void()>& work);
    /// Megabytes (10^6 bytes); 0 before the first call of times().
    double peak_growth_mb() const { return growth_mb_; }

  private:
    double growth_mb_ = 0;
    bool used_ = false;
};

/// Runs `work` in a child process of its own, so that the memory of one case does not count for the next, and returns the map of
/// figures that it returns, with "peak_mb", by how much the process
/// grew, and "process_mb", how large it was at most, added. If the child throws or dies, the map holds "note" with the reason
/// instead. The calling process must have no other threads.
fresco::Value run_case(const std::function<fresco::Value(Measure&)>& work);

/// What the system could still give out, megabytes.
double available_memory_mb();

}  // namespace bench

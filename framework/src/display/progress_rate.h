#pragma once

#include <chrono>
#include <string>

namespace fresco::host
{

/// How fast a stage counts, and how long it will take.
class ProgressRate
{
  public:
    /// A new unit or total begins a new count; a resumed stage's head start does not count as speed.
    void update(double done, double total, const std::string& unit);
    /// "120 of 400 steps, 1.9 steps/s, 2:27 left".
    std::string text() const;
    double done() const { return done_; }
    double total() const { return total_; }
    const std::string& unit() const { return unit_; }
    /// Units per second; 0 where it is too early to tell.
    double rate() const;

  private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point begin_ = Clock::now();
    Clock::time_point first_time_;
    Clock::time_point last_time_;
    double first_ = 0;
    double done_ = 0;
    double total_ = 0;
    std::string unit_;
    bool any_ = false;
};

}  // namespace fresco::host

#pragma once

#include <fresco/progress.h>

#include <atomic>

namespace fresco::optimize
{

/// What losses are given to learn of a cancellation: nothing within a step, which none of them could take up halfway. A run is
/// canceled between two steps.
class WholeSteps final : public Progress
{
  public:
    /// `run` must outlive it.
    explicit WholeSteps(const Progress& run) : run_(run) {}

    void check_canceled() const override
    {
        if (!within_)
            run_.check_canceled();
    }
    int threads() const override { return run_.threads(); }

    /// While there is one of these, a step is being made. Not to be nested; for the thread that makes the steps.
    class Step
    {
      public:
        explicit Step(WholeSteps& steps) : steps_(steps) { steps_.within_ = true; }
        ~Step() { steps_.within_ = false; }
        Step(const Step&) = delete;
        Step& operator=(const Step&) = delete;

      private:
        WholeSteps& steps_;
    };

  private:
    const Progress& run_;
    std::atomic<bool> within_{false};
};

}  // namespace fresco::optimize

#pragma once

#include "base/process.h"

#include <csignal>

namespace fresco::host
{

/// While it lives, SIGINT, SIGTERM, SIGHUP and SIGCHLD arrive as a readable descriptor instead of interrupting anything.
class StopSignals
{
  public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    int descriptor() const { return fd_.get(); }
    /// How many requests to stop (SIGINT, SIGTERM, SIGHUP) came since the last call. All but the first SIGTERM or SIGHUP do not
    /// count: schedulers send one to each process of a job, and job scripts pass theirs on.
    int take();

  private:
    sigset_t before_{};
    FileDescriptor fd_;
    bool told_to_end_ = false;
};

}  // namespace fresco::host

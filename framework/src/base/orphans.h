#pragma once

#include <sys/types.h>

#include <vector>

namespace fresco::host
{

/// What children of the host leave behind when they crash. It comes to the host, which ends it.
class Orphans
{
  public:
    /// Adopts from now on, unless the host was started with children of its own, whose orphans would look the same.
    Orphans();
    /// Kills the host's children that are not in `own`, with all that they started, and takes their ends.
    void end(const std::vector<pid_t>& own) const;

  private:
    bool adopts_;
};

}  // namespace fresco::host

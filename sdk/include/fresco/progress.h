#pragma once

#include <string_view>

namespace fresco
{

/// Where a long algorithm says how far it is and learns that it must stop. Callable from any thread.
class Progress
{
  public:
    virtual ~Progress();
    /// `done` of `total` units ("frames", "faces", "steps"); total 0 = unknown. Cheap: call it as often as you like.
    virtual void progress(double done, double total, std::string_view unit);
    /// Throws fresco::Canceled once the run must stop. Call it at least every second.
    virtual void check_canceled() const;
    /// Threads this work may use; results do not depend on it.
    virtual int threads() const;
};

}  // namespace fresco

#pragma once

#include <fresco/value.h>

#include <atomic>
#include <mutex>

namespace fresco::host
{

/// The worker's side of the channel to the host: one JSON line per event. Thread-safe.
class WorkerChannel
{
  public:
    /// Where nobody hears it any more, the process is asked to stop.
    void send(std::string_view event, Value::Map entries = {});
    /// Whether the channel was lost although the host is there: something in this process closed it.
    bool lost() const { return lost_; }

  private:
    std::mutex mutex_;
    std::atomic<bool> lost_{false};
};

/// From now on SIGTERM, SIGINT and SIGHUP ask this process to stop instead of ending it.
void take_stop_signals();
bool stop_requested();

}  // namespace fresco::host

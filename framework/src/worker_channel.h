#pragma once

#include <fresco/value.h>

#include <mutex>

namespace fresco::host
{

/// The worker's side of the channel to the host: one JSON line per event. Thread-safe.
class WorkerChannel
{
  public:
    void send(std::string_view event, Value::Map entries = {});

  private:
    std::mutex mutex_;
};

/// From now on SIGTERM and SIGINT ask this process to stop instead of ending it.
void take_stop_signals();
bool stop_requested();

}  // namespace fresco::host

#include "worker/worker_channel.h"

#include "base/process.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <iostream>

namespace fresco::host
{
namespace
{
std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void ask_to_stop(int)
{
    stop = true;
}
}  // namespace

void WorkerChannel::send(std::string_view event, Value::Map entries)
{
    entries.insert(entries.begin(), Value::Entry{"event", event});
    const std::string line = to_json(Value(std::move(entries))) + "\n";
    const std::lock_guard lock(mutex_);
    if (send_all(child_channel, line))
        return;
    lost_ = lost_ || (errno != EPIPE && errno != ECONNRESET);
    stop = true;
}

void take_stop_signals()
{
    struct sigaction action
    {
    };
    action.sa_handler = ask_to_stop;
    action.sa_flags = SA_RESTART;
    for (const int number : {SIGTERM, SIGINT, SIGHUP})
        sigaction(number, &action, nullptr);
}

bool stop_requested()
{
    return stop;
}

}  // namespace fresco::host

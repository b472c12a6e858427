#pragma once

#include <fresco/process.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <vector>

/// \file Processes of this program's own: how they are started, told apart from another with the same id, kept from outliving
/// the host, and how they end. The scheduler, the trial of plugins and the page use it.

namespace fresco::host
{

/// Exit codes of a worker that did not finish its stage; 0 means that it did.
enum WorkerExit
{
    worker_failed = 1,
    worker_missing_input = 3,
    worker_plugin = 4,
    worker_damaged_input = 10,  ///< The event "damaged" names the object.
    worker_canceled = 75
};

/// A process of this same program, started to do one job.
struct Child
{
    pid_t pid = -1;
    FileDescriptor channel;  ///< The child's descriptor child_channel, non-blocking: JSON lines to the host.
    FileDescriptor output;   ///< The child's standard output and error together, non-blocking.
};

/// Starts another process of this program with `arguments`, in its own session. The kernel kills it when the host ends, however
/// that happens. `environment` and `data_limit_mb` as in ProcessStart. The host must be single-threaded. Throws Error if no
/// process can be started.
Child start_child(const std::vector<std::string>& arguments, const EnvironmentChanges& environment = {},
                  double data_limit_mb = 0);

/// The file of this program, which another may have been put in the place of; empty where the system does not tell.
std::filesystem::path own_program();

/// How a process ended, and whether it had to be killed for the time that it took.
struct HeardEnd : ProcessEnd
{
    bool timed_out = false;
};

/// Adds the advice to raise the limit of processes to a text that has the system's words for their lack.
std::string with_process_limit(std::string text);

/// Passes on the lines that the leader of a process group sends over its channel and that it prints, until it ends. Kills it,
/// with all that it started, `limit` after its start or the last line over the channel.
HeardEnd hear_out(const Child& child, std::chrono::milliseconds limit, const std::function<void(const std::string&)>& said,
                  const std::function<void(const std::string&)>& printed);

/// The permissions that new files of this process lack (umask).
mode_t current_mask();

/// Writes everything to a file or a socket. False if that fails; errno says why: EPIPE if the other side of a socket is gone.
bool write_all(int file, std::string_view text);

}  // namespace fresco::host

#pragma once

#include <fresco/process.h>

#include <string>
#include <string_view>
#include <vector>

namespace fresco::host
{

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

/// The permissions that new files of this process lack (umask).
mode_t current_mask();

/// Writes everything to a socket; never raises SIGPIPE. False if that fails; errno says why: EPIPE if the other side is gone.
bool send_all(int socket, std::string_view text);

}  // namespace fresco::host

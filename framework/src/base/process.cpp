#include "base/process.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/socket.h>

namespace fresco::host
{

Child start_child(const std::vector<std::string>& arguments, const EnvironmentChanges& environment, double data_limit_mb)
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    data_limit_mb = 0;  // The sanitizer maps the whole address space at its start.
#endif
    int sockets[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0)
        throw Error(std::string("cannot start a process (socket): ") + std::strerror(errno));
    FileDescriptor channel(sockets[0]);
    const FileDescriptor its_channel(sockets[1]);
    fcntl(channel.get(), F_SETFL, fcntl(channel.get(), F_GETFL) | O_NONBLOCK);
    // The running file itself, even if another was installed in its place meanwhile.
    ProcessStart start{.file = "/proc/self/exe",
                       .arguments = {"fresco"},
                       .environment = environment,
                       .channel = its_channel.get(),
                       .own_session = true,
                       .data_limit_mb = data_limit_mb};
    start.arguments.insert(start.arguments.end(), arguments.begin(), arguments.end());
    // UCX, which Debian 13's libtorch brings, looks for its monitor at a socket and takes fatal signals over as soon as it is
    // loaded.
    start.environment.emplace_back("UCX_VFS_ENABLE", "n");
    start.environment.emplace_back("UCX_HANDLE_ERRORS", "none");
    Process started = start_process(start);
    return {started.pid, std::move(channel), std::move(started.output)};
}

mode_t current_mask()
{
    const mode_t mask = umask(0);
    umask(mask);
    return mask;
}

bool send_all(int socket, std::string_view text)
{
    while (!text.empty())
    {
        const ssize_t count = uninterrupted([&] { return send(socket, text.data(), text.size(), MSG_NOSIGNAL); });
        if (count <= 0)
            return false;  // errno stays.
        text.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
}

}  // namespace fresco::host

#include "base/process.h"
#include "base/common.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

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

fs::path own_program()
{
    std::error_code error;
    return fs::read_symlink("/proc/self/exe", error);
}

std::string with_process_limit(std::string text)
{
    if (text.find(std::strerror(EAGAIN)) != std::string::npos && text.find("ulimit -u") == std::string::npos)
        text += ": no more processes or threads may be started; raise the limit (ulimit -u)";
    return text;
}

HeardEnd hear_out(const Child& child, std::chrono::milliseconds limit, const std::function<void(const std::string&)>& said,
                  const std::function<void(const std::string&)>& printed)
{
    using Clock = std::chrono::steady_clock;
    auto begin = Clock::now();
    LineBuffer buffers[2];
    pollfd streams[2]{{child.channel.get(), POLLIN, 0}, {child.output.get(), POLLIN, 0}};
    const auto read = [&]
    {
        for (const int which : {0, 1})
        {
            if (streams[which].fd >= 0 && !buffers[which].read_from(streams[which].fd))
                streams[which].fd = -1;  // It ended: poll passes it over.
            for (std::string line; buffers[which].next(line);)
            {
                (which == 0 ? said : printed)(line);
                begin = which == 0 ? Clock::now() : begin;
            }
        }
    };
    HeardEnd end;
    while (!take_group_end(child.pid, end))
    {
        read();
        if (Clock::now() - begin > limit && !std::exchange(end.timed_out, true))
            kill(child.pid, SIGKILL);
        poll(streams, 2, 20);
    }
    read();
    return end;
}

mode_t current_mask()
{
    const mode_t mask = umask(0);
    umask(mask);
    return mask;
}

bool write_all(int file, std::string_view text)
{
    while (!text.empty())
    {
        const ssize_t count = uninterrupted([&] { return write(file, text.data(), text.size()); });
        if (count <= 0)
            return false;  // errno stays.
        text.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
}

}  // namespace fresco::host

#include <fresco/error.h>
#include <fresco/host/process.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace fresco::host
{
namespace
{

[[noreturn]] void cannot_start(const char* what)
{
    throw Error(std::string("cannot start a process (") + what + "): " + std::strerror(errno));
}

/// The same descriptor at a number above those that the child gives a meaning.
FileDescriptor out_of_the_way(int fd)
{
    const FileDescriptor original(fd);
    FileDescriptor moved(fcntl(fd, F_DUPFD_CLOEXEC, 10));
    if (!moved.valid())
        cannot_start("descriptors");
    return moved;
}

void set_nonblocking(int fd)
{
    fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
}

std::vector<std::string> merged_environment(const std::vector<std::pair<std::string, std::string>>& changes)
{
    std::vector<std::string> merged;
    for (char** entry = environ; *entry != nullptr; ++entry)
    {
        const std::string_view text = *entry;
        bool replaced = false;
        for (const auto& [name, value] : changes)
            replaced = replaced || (text.size() > name.size() && text.substr(0, name.size()) == name && text[name.size()] == '=');
        if (!replaced)
            merged.emplace_back(text);
    }
    for (const auto& [name, value] : changes)
        merged.push_back(name + "=" + value);
    return merged;
}

std::vector<char*> pointers(std::vector<std::string>& texts)
{
    std::vector<char*> result;
    result.reserve(texts.size() + 1);
    for (auto& text : texts)
        result.push_back(text.data());
    result.push_back(nullptr);
    return result;
}

/// Between fork and exec: nothing that allocates.
[[noreturn]] void become_child(pid_t host, int input, int output, int channel, char* const* arguments, char* const* environment)
{
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != host)  // the host ended before the line above
        _exit(127);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    for (const int number : {SIGINT, SIGTERM, SIGPIPE, SIGCHLD})
        signal(number, SIG_DFL);
    if (dup2(input, STDIN_FILENO) < 0 || dup2(output, STDOUT_FILENO) < 0 || dup2(output, STDERR_FILENO) < 0 ||
        dup2(channel, child_channel) < 0)
        _exit(127);
    // The running file itself, even if another was installed in its place meanwhile.
    execve("/proc/self/exe", arguments, environment);
    _exit(127);
}

}  // namespace

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept
{
    if (this != &other)
    {
        reset();
        fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
}

void FileDescriptor::reset()
{
    if (fd_ >= 0)
        close(fd_);
    fd_ = -1;
}

Child start_child(const std::vector<std::string>& arguments, const std::vector<std::pair<std::string, std::string>>& environment)
{
    std::vector<std::string> argument_texts{"fresco"};
    argument_texts.insert(argument_texts.end(), arguments.begin(), arguments.end());
    std::vector<std::string> environment_texts = merged_environment(environment);
    const std::vector<char*> argv = pointers(argument_texts);
    const std::vector<char*> envp = pointers(environment_texts);

    int sockets[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0)
        cannot_start("socket");
    Child child;
    child.channel = FileDescriptor(sockets[0]);
    const FileDescriptor channel = out_of_the_way(sockets[1]);
    int pipes[2];
    if (pipe2(pipes, O_CLOEXEC) != 0)
        cannot_start("pipe");
    child.output = FileDescriptor(pipes[0]);
    const FileDescriptor output = out_of_the_way(pipes[1]);
    const FileDescriptor input(open("/dev/null", O_RDONLY | O_CLOEXEC));
    set_nonblocking(child.channel.get());
    set_nonblocking(child.output.get());

    const pid_t host = getpid();
    child.pid = fork();
    if (child.pid < 0)
        cannot_start("fork");
    if (child.pid == 0)
        become_child(host, input.get(), output.get(), channel.get(), argv.data(), envp.data());
    setpgid(child.pid, child.pid);
    return child;
}

bool take_end(pid_t pid, ChildEnd& end)
{
    int status = 0;
    rusage usage{};
    if (wait4(pid, &status, WNOHANG, &usage) != pid)
        return false;
    end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    end.peak_memory_mb = static_cast<double>(usage.ru_maxrss) / 1024.0;
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6; };
    end.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    return true;
}

std::string signal_text(int signal)
{
    const char* name = sigdescr_np(signal);
    return std::string(name != nullptr ? name : "unknown") + " (signal " + std::to_string(signal) + ")";
}

bool LineBuffer::read_from(int fd)
{
    char block[16384];
    for (;;)
    {
        const ssize_t count = read(fd, block, sizeof block);
        if (count > 0)
            buffer_.append(block, static_cast<std::size_t>(count));
        else if (count < 0 && errno == EINTR)
            continue;
        else
            return count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
    }
}

bool LineBuffer::next(std::string& line)
{
    const std::size_t end = buffer_.find('\n', start_);
    if (end == std::string::npos)
    {
        buffer_.erase(0, start_);
        start_ = 0;
        return false;
    }
    line = buffer_.substr(start_, end - start_);
    start_ = end + 1;
    return true;
}

bool send_all(int socket, std::string_view text)
{
    while (!text.empty())
    {
        const ssize_t count = send(socket, text.data(), text.size(), MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR)
            continue;
        if (count <= 0)
            return false;
        text.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
}

}  // namespace fresco::host

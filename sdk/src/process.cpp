#include <fresco/error.h>
#include <fresco/process.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <poll.h>
#include <sstream>
#include <string.h>
#include <string>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

namespace fresco
{
namespace fs = std::filesystem;
namespace
{

[[noreturn]] void cannot_start(const char* what)
{
    throw Error(std::string("cannot start a process (") + what + "): " + std::strerror(errno) +
                (errno == EAGAIN ? ": raise the limit of processes (ulimit -u)" : ""));
}

/// Moves a descriptor to a number above those that the child uses.
FileDescriptor out_of_the_way(int fd)
{
    const FileDescriptor original(fd);
    FileDescriptor moved(fcntl(fd, F_DUPFD_CLOEXEC, 10));
    if (!moved.valid())
        cannot_start("descriptors");
    return moved;
}

std::vector<std::string> merged_environment(const EnvironmentChanges& changes)
{
    std::vector<std::string> merged;
    for (char** entry = environ; *entry != nullptr; ++entry)
    {
        const std::string_view text = *entry;
        const std::string_view name = text.substr(0, text.find('='));
        if (std::ranges::find(changes, name, &EnvironmentChanges::value_type::first) == changes.end())
            merged.emplace_back(text);
    }
    for (const auto& [name, value] : changes)
        merged.emplace_back(name).append("=").append(value);
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

struct Descriptors
{
    int input;
    int output;
    int channel;
    int failure;  ///< Gets errno if there is no new program; closed by its start.
};

/// In the child: sends the parent the reason why exec failed.
[[noreturn]] void give_up(int failure)
{
    const int reason = errno;
    (void)!::write(failure, &reason, sizeof reason);
    _exit(127);
}

/// In the child, in the parent's memory: must not allocate.
[[noreturn]] void become(const ProcessStart& start, pid_t parent, const Descriptors& descriptors, char* const* arguments,
                         char* const* environment)
{
    if (start.own_session)
        setsid();
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent)  // It ended before the line above.
        _exit(127);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    for (const int number : {SIGINT, SIGTERM, SIGPIPE, SIGCHLD})
        signal(number, SIG_DFL);
    const bool has_channel = descriptors.channel >= 0;
    const int failure = has_channel ? child_channel + 1 : child_channel;
    if (::dup2(descriptors.input, STDIN_FILENO) < 0 || ::dup2(descriptors.output, STDOUT_FILENO) < 0 ||
        ::dup2(descriptors.output, STDERR_FILENO) < 0 || (has_channel && ::dup2(descriptors.channel, child_channel) < 0) ||
        ::dup2(descriptors.failure, failure) < 0 || fcntl(failure, F_SETFD, FD_CLOEXEC) != 0)
        give_up(descriptors.failure);
    close_range(static_cast<unsigned>(failure) + 1, ~0U, 0);
    if (start.data_limit_mb > 0)
    {
        const auto bytes = static_cast<rlim_t>(start.data_limit_mb * 1024 * 1024);
        const rlimit data{bytes, bytes};
        const rlimit core{0, 0};
        setrlimit(RLIMIT_DATA, &data);
        setrlimit(RLIMIT_CORE, &core);
    }
    if (start.folder.empty() || chdir(start.folder.c_str()) == 0)
        execve(start.file.c_str(), arguments, environment);
    give_up(failure);
}

std::pair<FileDescriptor, FileDescriptor> made_pipe()
{
    int ends[2]{-1, -1};
    if (::pipe2(ends, O_CLOEXEC) != 0)
        cannot_start("pipe");
    return {FileDescriptor(ends[0]), out_of_the_way(ends[1])};
}

}  // namespace

std::string find_program(const std::string& name)
{
    const auto runs = [](const std::string& file)
    {
        struct stat status = {};
        return stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) && access(file.c_str(), X_OK) == 0;
    };
    if (name.find('/') != std::string::npos)
        return runs(name) ? name : "";
    const char* variable = std::getenv("PATH");
    const std::string path = variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin";
    std::istringstream folders(path);
    for (std::string folder; std::getline(folders, folder, ':');)
        // The program starts in another folder.
        if (const fs::path file = fs::path(folder) / name; !folder.empty() && runs(file))
            return fs::absolute(file);
    return {};
}

Process start_process(const ProcessStart& start)
{
    std::vector<std::string> argument_texts = start.arguments;
    std::vector<std::string> environment_texts = merged_environment(start.environment);
    const std::vector<char*> argv = pointers(argument_texts);
    const std::vector<char*> envp = pointers(environment_texts);
    auto [printed, output] = made_pipe();
    auto [failed, failure] = made_pipe();
    const int nothing = uninterrupted([] { return ::open("/dev/null", O_RDONLY | O_CLOEXEC); });
    if (nothing < 0)
        cannot_start("/dev/null");
    const FileDescriptor input = out_of_the_way(nothing);
    const FileDescriptor channel = start.channel >= 0 ? out_of_the_way(dup(start.channel)) : FileDescriptor();
    fcntl(printed.get(), F_SETFL, fcntl(printed.get(), F_GETFL) | O_NONBLOCK);

    const pid_t parent = getpid();
    const Descriptors descriptors{input.get(), output.get(), channel.get(), failure.get()};
    // The child has this process's memory until it is another program: copying a large process's page tables takes longer than
    // all else that starting a program takes.
    const pid_t pid = ::vfork();
    if (pid == 0)
        become(start, parent, descriptors, argv.data(), envp.data());
    if (pid < 0)
        cannot_start("fork");
    failure.reset();
    int reason = 0;
    const auto read_reason = [&reason, from = failed.get()] { return ::read(from, &reason, sizeof reason); };
    if (uninterrupted(read_reason) == static_cast<ssize_t>(sizeof reason))
    {
        ::waitpid(pid, nullptr, 0);
        throw Error(start.file + ": cannot be started: " + std::strerror(reason));
    }
    return {pid, std::move(printed)};
}

bool take_end(pid_t pid, ProcessEnd& end)
{
    int status = 0;
    rusage usage{};
    if (wait4(pid, &status, WNOHANG, &usage) != pid)
        return false;
    end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    end.peak_memory_mb = static_cast<double>(usage.ru_maxrss) / 1024.0;
    return true;
}

bool take_group_end(pid_t pid, ProcessEnd& end)
{
    // While the leader is not taken its number cannot be another group's.
    siginfo_t info{};
    if (waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != pid)
        return false;
    ::kill(-pid, SIGKILL);
    return take_end(pid, end);
}

std::string signal_text(int signal)
{
    const char* name = sigdescr_np(signal);
    return fmt::format("{} (signal {})", name != nullptr ? name : "unknown", signal);
}

bool LineBuffer::read_from(int fd)
{
    char block[16384];
    constexpr std::size_t at_a_time = std::size_t{1} << 20U;
    // Whoever writes without end must not keep the reader from all else.
    for (std::size_t taken = 0; taken < at_a_time;)
    {
        const ssize_t count = uninterrupted([&] { return ::read(fd, block, sizeof block); });
        if (count <= 0)
            return count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
        buffer_.append(block, static_cast<std::size_t>(count));
        taken += static_cast<std::size_t>(count);
    }
    return true;
}

bool LineBuffer::next(std::string& line)
{
    const std::size_t end = buffer_.find('\n', start_);
    if (end == std::string::npos ? buffer_.size() - start_ > longest_ : end - start_ > longest_)
    {
        line = buffer_.substr(start_, longest_);
        start_ += longest_;
        return true;
    }
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

std::vector<pid_t> children_of(pid_t pid)
{
    std::vector<pid_t> found;
    std::error_code error;
    for (fs::directory_iterator task(fmt::format("/proc/{}/task", pid), error), end; !error && task != end; task.increment(error))
    {
        std::ifstream children(task->path() / "children");
        for (pid_t child = 0; children >> child;)
            found.push_back(child);
    }
    return found;
}

void signal_descendants(pid_t pid, int number)
{
    // The lowest first: children of a process that has ended are another's.
    for (const pid_t child : children_of(pid))
    {
        signal_descendants(child, number);
        kill(child, number);
    }
}

void adopt_orphans()
{
    prctl(PR_SET_CHILD_SUBREAPER, 1);
}

void end_descendants(const std::vector<pid_t>& spared)
{
    constexpr int patience = 200;  // times 10 ms; what the kernel itself holds up ends when it can
    for (int tries = 0; tries < patience; ++tries)
    {
        // Children of processes that ended are adopted meanwhile.
        std::vector<pid_t> children = children_of(getpid());
        std::erase_if(children, [&](pid_t child) { return std::ranges::find(spared, child) != spared.end(); });
        if (children.empty())
            return;
        for (const pid_t child : children)
        {
            signal_descendants(child, SIGKILL);
            kill(child, SIGKILL);
            waitpid(child, nullptr, WNOHANG);
        }
        poll(nullptr, 0, 10);
    }
}

}  // namespace fresco

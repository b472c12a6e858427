#include "run_program.h"

#include <fresco/error.h>
#include <fresco/process.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <poll.h>
#include <sys/prctl.h>
#include <unistd.h>

namespace fresco::command
{
namespace
{

/// While a program runs, the end of the host ends first what the program started, then this process; the kernel alone would leave
/// what is further down.
class HostWatch
{
  public:
    HostWatch()
    {
        // Nor what is printed to a host that is gone.
        signal(SIGPIPE, SIG_IGN);
        prctl(PR_SET_PDEATHSIG, SIGTERM);
    }
    HostWatch(const HostWatch&) = delete;
    HostWatch& operator=(const HostWatch&) = delete;
    ~HostWatch()
    {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        end_if_gone();
    }
    void end_if_gone() const
    {
        if (getppid() == host_)
            return;
        end_descendants();
        std::_Exit(EXIT_FAILURE);
    }

  private:
    const pid_t host_ = getppid();
};

/// SIGTERM to the program and all it started; SIGKILL to what is left when the program has ended, after 5 s at latest.
void stop(const Process& program)
{
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    signal_descendants(getpid(), SIGTERM);
    ProcessEnd end;
    while (!take_end(program.pid, end) && std::chrono::steady_clock::now() < patience)
        poll(nullptr, 0, 20);
    end_descendants();
}

}  // namespace

ProcessEnd run_program(const std::vector<std::string>& words, const EnvironmentChanges& environment,
                       const std::filesystem::path& folder, RunContext& run, const TakeLine& take_line)
{
    const std::string file = find_program(words.front());
    if (file.empty())
        throw Error(words.front() + ": program not found" +
                    (words.front().find('/') == std::string::npos ? " in PATH" : " or not executable"));
    const HostWatch host;
    const Process program =
        start_process({.file = file, .arguments = words, .environment = environment, .folder = folder.string()});
    LineBuffer output;
    ProcessEnd end;
    for (bool ended = false; !ended;)
    {
        pollfd descriptor{program.output.get(), POLLIN, 0};
        poll(&descriptor, 1, 100);
        if ((descriptor.revents & POLLIN) == 0 && (descriptor.revents & POLLHUP) != 0)
            poll(nullptr, 0, 5);  // It closed its output and goes on.
        host.end_if_gone();
        try
        {
            run.check_canceled();
        }
        catch (const Canceled&)
        {
            stop(program);
            throw;
        }
        ended = take_end(program.pid, end);
        output.read_from(program.output.get());
        std::string line;
        while (output.next(line))
            take_line(line);
    }
    // What it left behind must not write into its outputs any more.
    end_descendants();
    if (const std::string rest = output.rest(); !rest.empty())
        take_line(rest);
    return end;
}

}  // namespace fresco::command

#include <fresco/error.h>
#include <fresco/programs/run_program.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <unistd.h>

namespace fresco::programs
{
namespace
{

/// If the host dies while a program runs, ends everything that the program started, then this process. The kernel would end only
/// this process's own children.
class HostWatch
{
  public:
    HostWatch()
    {
        // Printing to a host that is gone must not end this process before the program.
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

ProcessEnd run_program(const ProcessStart& start, RunContext& run, const std::function<void(const std::string&)>& take_line,
                       double most_seconds)
{
    const HostWatch host;
    const Process program = start_process(start);
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
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
            if (std::chrono::duration<double>(Clock::now() - begin).count() > most_seconds)
                throw Error(fmt::format("{}: it runs for more than {:g} s, the limit", start.file, most_seconds));
        }
        catch (...)
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
    // Processes that it left behind must no longer write into its outputs.
    end_descendants();
    if (const std::string rest = output.rest(); !rest.empty())
        take_line(rest);
    return end;
}

}  // namespace fresco::programs

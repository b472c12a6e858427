#include <fresco/process_tree.h>

#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <poll.h>
#include <string>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>

namespace fresco
{
namespace fs = std::filesystem;

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

std::vector<pid_t> descendants_of(pid_t pid)
{
    std::vector<pid_t> found;
    for (const pid_t child : children_of(pid))
    {
        found.push_back(child);
        const std::vector<pid_t> further = descendants_of(child);
        found.insert(found.end(), further.begin(), further.end());
    }
    return found;
}

void signal_descendants(pid_t pid, int number)
{
    for (const pid_t each : descendants_of(pid))
        kill(each, number);
}

void adopt_orphans()
{
    prctl(PR_SET_CHILD_SUBREAPER, 1);
}

void end_descendants()
{
    constexpr int patience = 200;  // times 10 ms; what the kernel itself holds up ends when it can
    for (int tries = 0; tries < patience; ++tries)
    {
        signal_descendants(getpid(), SIGKILL);
        // Those of the ones that ended are adopted meanwhile.
        pid_t taken = 0;
        do
            taken = waitpid(-1, nullptr, WNOHANG);
        while (taken > 0);
        if (taken < 0)
            return;
        poll(nullptr, 0, 10);
    }
}

}  // namespace fresco

#include "base/orphans.h"
#include <fresco/process.h>

#include <algorithm>
#include <csignal>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fresco::host
{

Orphans::Orphans() : adopts_(children_of(getpid()).empty())
{
    if (adopts_)
        adopt_orphans();
}

void Orphans::end(const std::vector<pid_t>& own) const
{
    constexpr int patience = 200;  // times 5 ms; what the kernel itself holds up ends when it can
    for (int tries = 0; adopts_ && tries < patience; ++tries)
    {
        bool left = false;
        for (const pid_t child : children_of(getpid()))
        {
            if (std::find(own.begin(), own.end(), child) != own.end())
                continue;
            left = true;
            signal_descendants(child, SIGKILL);
            kill(child, SIGKILL);
            waitpid(child, nullptr, WNOHANG);
        }
        if (!left)
            return;
        poll(nullptr, 0, 5);
    }
}

}  // namespace fresco::host

// If the environment variable FRESCO_FAULT is "POINT" or "POINT@STAGE", the process that reaches this point kills the host
// and itself.
#include "base/fault.h"

#include <csignal>
#include <cstdlib>
#include <string>
#include <unistd.h>

namespace fresco::host
{
namespace
{
std::string& fault_stage()
{
    static std::string stage;
    return stage;
}
}  // namespace

void set_fault_stage(std::string_view stage)
{
    fault_stage() = stage;
}

void fault_point(std::string_view point)
{
    const char* wanted = std::getenv("FRESCO_FAULT");
    if (wanted == nullptr)
        return;
    const std::string& stage = fault_stage();
    if (wanted != point && wanted != std::string(point) + "@" + stage)
        return;
    if (!stage.empty())
        kill(getppid(), SIGKILL);
    kill(getpid(), SIGKILL);
}

}  // namespace fresco::host

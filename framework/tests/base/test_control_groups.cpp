#include "base/machine.h"
#include "catch.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <array>
#include <filesystem>
#include <limits>
#include <map>

using namespace fresco::host;

namespace
{

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Files of a /proc and a /sys/fs/cgroup of a test's own.
using Files = std::map<std::string, std::string>;
/// Free memory and cores.
using Limits = std::array<double, 2>;

Limits limits_of(const Files& files)
{
    const fresco::testing::TemporaryFolder folder;
    for (const auto& [name, text] : files)
    {
        std::filesystem::create_directories((folder.path() / name).parent_path());
        fresco::write_file(folder.path() / name, text + "\n");
    }
    const ControlGroupLimits found = control_group_limits(folder.path() / "proc", folder.path());
    return {found.free_memory_mb, found.cores};
}

}  // namespace

TEST_CASE("the narrowest of a job's control groups counts, whichever of its ancestors that is", "[machine]")
{
    CHECK(limits_of({{"proc/cgroup", "0::/slurm/job_7/step_0"},
                     {"sys/fs/cgroup/slurm/memory.max", "max"},
                     {"sys/fs/cgroup/slurm/cpu.max", "max 100000"},
                     {"sys/fs/cgroup/slurm/job_7/memory.max", "2147483648"},
                     {"sys/fs/cgroup/slurm/job_7/memory.current", "1073741824"},
                     {"sys/fs/cgroup/slurm/job_7/cpu.max", "150000 100000"},
                     {"sys/fs/cgroup/slurm/job_7/step_0/memory.max", "4294967296"},
                     {"sys/fs/cgroup/slurm/job_7/step_0/memory.current", "104857600"}}) == Limits{1024, 1.5});
}

TEST_CASE("control groups of version 1 have a hierarchy for each controller", "[machine]")
{
    CHECK(limits_of({{"proc/cgroup", "4:memory:/job\n3:cpuacct,cpu:/job/step\n0::/"},
                     {"sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712"},
                     {"sys/fs/cgroup/memory/job/memory.limit_in_bytes", "1073741824"},
                     {"sys/fs/cgroup/memory/job/memory.usage_in_bytes", "2147483648"},
                     {"sys/fs/cgroup/cpu/job/cpu.cfs_quota_us", "400000"},
                     {"sys/fs/cgroup/cpu/job/cpu.cfs_period_us", "100000"},
                     {"sys/fs/cgroup/cpu/job/step/cpu.cfs_quota_us", "-1"}}) == Limits{0, 4});
}

TEST_CASE("in a container the topmost group that can be seen is the container's own", "[machine]")
{
    for (const char* group : {"0::/", "0::/docker/abc", "0::/../elsewhere"})
        CHECK(limits_of({{"proc/cgroup", group}, {"sys/fs/cgroup/memory.max", "1073741824"}}) == Limits{1024, infinity});
}

TEST_CASE("nothing that can be read limits nothing", "[machine]")
{
    CHECK(limits_of(
              {{"proc/cgroup", "nonsense\n0::/a"}, {"sys/fs/cgroup/a/memory.max", "much"}, {"sys/fs/cgroup/a/cpu.max", "10"}}) ==
          Limits{infinity, infinity});
    CHECK(available_cores() >= 1);
}

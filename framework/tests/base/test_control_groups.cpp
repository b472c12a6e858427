#include "base/machine.h"
#include "catch.h"

#include <fresco/testing.h>

#include <cmath>
#include <filesystem>
#include <fstream>

using namespace fresco::host;
namespace fs = std::filesystem;

namespace
{

/// A /proc and a /sys/fs/cgroup of a test's own.
struct Groups
{
    fresco::testing::TemporaryFolder folder;

    void write(const std::string& name, const std::string& text) const
    {
        fs::create_directories((folder.path() / name).parent_path());
        std::ofstream(folder.path() / name) << text << "\n";
    }
    ControlGroupLimits limits() const { return control_group_limits(folder.path() / "proc", folder.path()); }
};

}  // namespace

TEST_CASE("the narrowest of a job's control groups counts, whichever of its ancestors that is", "[machine]")
{
    const Groups groups;
    groups.write("proc/mountinfo", "22 1 0:20 / /proc rw - proc proc rw\n"
                                   "30 22 0:26 / /sys/fs/cgroup rw,nosuid shared:4 - cgroup2 cgroup2 rw");
    groups.write("proc/cgroup", "0::/slurm/job_7/step_0");
    groups.write("sys/fs/cgroup/slurm/memory.max", "max");
    groups.write("sys/fs/cgroup/slurm/cpu.max", "max 100000");
    groups.write("sys/fs/cgroup/slurm/job_7/memory.max", "2147483648");
    groups.write("sys/fs/cgroup/slurm/job_7/memory.current", "1073741824");
    groups.write("sys/fs/cgroup/slurm/job_7/cpu.max", "150000 100000");
    groups.write("sys/fs/cgroup/slurm/job_7/step_0/memory.max", "4294967296");
    groups.write("sys/fs/cgroup/slurm/job_7/step_0/memory.current", "104857600");
    CHECK(groups.limits().memory_mb == 2048);
    CHECK(groups.limits().free_memory_mb == 1024);
    CHECK(groups.limits().cores == 1.5);
}

TEST_CASE("control groups of version 1 have a hierarchy for each controller", "[machine]")
{
    const Groups groups;
    groups.write("proc/mountinfo", "31 22 0:27 / /sys/fs/cgroup/cpu,cpuacct rw shared:5 - cgroup cgroup rw,cpu,cpuacct\n"
                                   "32 22 0:28 / /sys/fs/cgroup/mem\\040ory rw shared:6 - cgroup cgroup rw,memory\n"
                                   "33 22 0:29 / /sys/fs/cgroup/unified rw - cgroup2 cgroup2 rw");
    groups.write("proc/cgroup", "4:memory:/job\n3:cpuacct,cpu:/job/step\n0::/");
    groups.write("sys/fs/cgroup/mem ory/memory.limit_in_bytes", "9223372036854771712");
    groups.write("sys/fs/cgroup/mem ory/job/memory.limit_in_bytes", "1073741824");
    groups.write("sys/fs/cgroup/mem ory/job/memory.usage_in_bytes", "2147483648");
    groups.write("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_quota_us", "400000");
    groups.write("sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_period_us", "100000");
    groups.write("sys/fs/cgroup/cpu,cpuacct/job/step/cpu.cfs_quota_us", "-1");
    CHECK(groups.limits().memory_mb == 1024);
    CHECK(groups.limits().free_memory_mb == 0);
    CHECK(groups.limits().cores == 4);
}

TEST_CASE("in a container the group at the mount point is the topmost that can be seen", "[machine]")
{
    const Groups groups;
    groups.write("proc/mountinfo", "30 22 0:26 /docker/abc /sys/fs/cgroup rw - cgroup2 cgroup rw");
    groups.write("sys/fs/cgroup/memory.max", "1073741824");
    groups.write("sys/fs/cgroup/inner/memory.max", "536870912");
    groups.write("proc/cgroup", "0::/docker/abc");
    CHECK(groups.limits().memory_mb == 1024);
    groups.write("proc/cgroup", "0::/docker/abc/inner");
    CHECK(groups.limits().memory_mb == 512);
    groups.write("proc/cgroup", "0::/elsewhere");
    CHECK(groups.limits().memory_mb == 1024);
}

TEST_CASE("nothing that can be read limits nothing", "[machine]")
{
    const Groups groups;
    groups.write("proc/mountinfo", "nonsense\n30 22 0:26 / /sys/fs/cgroup rw - cgroup2 cgroup2 rw");
    groups.write("proc/cgroup", "nonsense\n0::/a");
    groups.write("sys/fs/cgroup/a/memory.max", "much");
    groups.write("sys/fs/cgroup/a/cpu.max", "10");
    CHECK(std::isinf(groups.limits().memory_mb));
    CHECK(std::isinf(groups.limits().cores));
    CHECK(available_cores() >= 1);
    CHECK(machine_memory_mb() >= available_memory_mb());
}

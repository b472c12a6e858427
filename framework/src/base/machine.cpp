#include "base/machine.h"
#include "base/common.h"
#include <fresco/process.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <dlfcn.h>
#include <fstream>
#include <iterator>
#include <optional>
#include <sched.h>
#include <set>
#include <sstream>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>

namespace fresco::host
{

namespace
{

constexpr double bytes_per_mb = 1024.0 * 1024.0;

bool lists(const std::string& names, const std::string& name)
{
    return ("," + names + ",").find("," + name + ",") != std::string::npos;
}

/// Folders of the groups that the process is in, the topmost first: of a controller, or of version 2 if that is empty. In a
/// container the topmost that can be seen is the container's own.
std::vector<fs::path> folders(const fs::path& proc, const fs::path& root, const std::string& controller)
{
    std::vector<fs::path> result{root / "sys/fs/cgroup" / controller};
    std::ifstream groups(proc / "cgroup");
    for (std::string line; std::getline(groups, line);)
    {
        // "4:memory:/job_7", of the version 2 "0::/job_7"
        std::istringstream fields(line);
        std::string number, names, group;
        if (std::getline(fields, number, ':') && std::getline(fields, names, ':') && std::getline(fields, group) &&
            (controller.empty() ? names.empty() : lists(names, controller)))
            for (const fs::path& name : fs::path(group).relative_path())
                if (name != "..")
                    result.push_back(result.back() / name);
    }
    return result;
}

/// Returns nothing for "max" and a missing file.
std::optional<double> number_in(const fs::path& file)
{
    std::ifstream stream(file);
    double number = 0;
    return stream >> number && number >= 0 ? std::optional(number) : std::nullopt;
}

void narrow_memory(ControlGroupLimits& limits, std::optional<double> most, std::optional<double> used)
{
    if (most)
        limits.free_memory_mb = std::min(limits.free_memory_mb, std::max(0.0, *most - used.value_or(0)) / bytes_per_mb);
}

void narrow_cores(ControlGroupLimits& limits, std::optional<double> quota, std::optional<double> period)
{
    if (quota && period && *quota > 0 && *period > 0)
        limits.cores = std::min(limits.cores, *quota / *period);
}

/// Text after "name ... : " in the first line that begins with `name`.
std::string line_of(const char* file, const std::string& name)
{
    std::ifstream stream(file);
    std::string line;
    while (std::getline(stream, line))
        if (line.starts_with(name))
        {
            const auto colon = line.find(':');
            const auto begin = line.find_first_not_of(" \t", colon == std::string::npos ? name.size() : colon + 1);
            return begin == std::string::npos ? "" : line.substr(begin);
        }
    return "";
}

/// The number there; 0 where the file does not have it.
double number_of(const char* file, const std::string& name)
{
    return std::strtod(line_of(file, name).c_str(), nullptr);
}

}  // namespace

ControlGroupLimits control_group_limits(const fs::path& proc, const fs::path& root)
{
    ControlGroupLimits limits;
    for (const fs::path& group : folders(proc, root, ""))
    {
        narrow_memory(limits, number_in(group / "memory.max"), number_in(group / "memory.current"));
        std::ifstream cpu(group / "cpu.max");
        if (double quota = 0, period = 0; cpu >> quota >> period)
            narrow_cores(limits, quota, period);
    }
    for (const fs::path& group : folders(proc, root, "memory"))
        narrow_memory(limits, number_in(group / "memory.limit_in_bytes"), number_in(group / "memory.usage_in_bytes"));
    for (const fs::path& group : folders(proc, root, "cpu"))
        narrow_cores(limits, number_in(group / "cpu.cfs_quota_us"), number_in(group / "cpu.cfs_period_us"));
    return limits;
}

Value processor_capability()
{
    static const std::vector<std::string> telling{"sse4_2",      "avx",      "f16c",     "fma",      "avx2",
                                                  "avx512f",     "avx512bw", "avx512vl", "avx512dq", "avx512_vnni",
                                                  "avx512_bf16", "amx_tile", "asimd",    "sve"};
    std::string flags = line_of("/proc/cpuinfo", "flags");
    if (flags.empty())
        flags = line_of("/proc/cpuinfo", "Features");
    std::istringstream words(flags);
    const std::vector<std::string> all{std::istream_iterator<std::string>(words), {}};
    std::string features;
    for (const auto& name : telling)
        if (std::ranges::find(all, name) != all.end())
            features += (features.empty() ? "" : " ") + name;
    return Value::Map{{"model", line_of("/proc/cpuinfo", "model name")}, {"features", features}};
}

Value computing_place(bool on_gpu)
{
    std::set<std::string> models;
    std::error_code error;
    if (on_gpu)
        for (const auto& gpu : fs::directory_iterator("/proc/driver/nvidia/gpus", error))
            models.insert(line_of((gpu.path() / "information").c_str(), "Model"));
    return Value::Map{{"features", processor_capability().at("features")}, {"gpus", Value::List(models.begin(), models.end())}};
}

int available_cores()
{
    cpu_set_t set;
    CPU_ZERO(&set);
    const int usable = sched_getaffinity(0, sizeof set, &set) == 0 ? std::max(1, CPU_COUNT(&set)) : 1;
    const double allowed = control_group_limits().cores;
    return allowed < usable ? std::max(1, static_cast<int>(std::ceil(allowed))) : usable;
}

double available_memory_mb()
{
    return std::min(number_of("/proc/meminfo", "MemAvailable") / 1024.0, std::max(1.0, control_group_limits().free_memory_mb));
}

double peak_memory_mb()
{
    return number_of("/proc/self/status", "VmHWM") / 1024.0;
}

double peak_memory_of_programs_mb()
{
    rusage usage{};
    return getrusage(RUSAGE_CHILDREN, &usage) == 0 ? static_cast<double>(usage.ru_maxrss) / 1024.0 : 0;
}

double memory_of_tree_mb(pid_t pid)
{
    std::ifstream file("/proc/" + std::to_string(pid) + "/statm");
    double mapped = 0;
    double resident = 0;
    if (!(file >> mapped >> resident))
        return 0;
    double sum = resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
    for (const pid_t child : children_of(pid))
        sum += memory_of_tree_mb(child);
    return sum;
}

bool machine_has_gpu()
{
    static const bool has = []
    {
        // The driver's own library: it knows of broken drivers and of CUDA_VISIBLE_DEVICES.
        void* driver = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
        if (driver == nullptr)
            return false;
        const auto initialize = reinterpret_cast<int (*)(unsigned)>(dlsym(driver, "cuInit"));
        const auto count_devices = reinterpret_cast<int (*)(int*)>(dlsym(driver, "cuDeviceGetCount"));
        int count = 0;
        return initialize != nullptr && count_devices != nullptr && initialize(0) == 0 && count_devices(&count) == 0 && count > 0;
    }();
    return has;
}

std::int64_t oom_kills()
{
    return static_cast<std::int64_t>(number_of("/proc/vmstat", "oom_kill"));
}

std::string program_version()
{
    return FRESCO_VERSION;
}

}  // namespace fresco::host

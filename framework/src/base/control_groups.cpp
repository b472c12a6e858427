#include "base/control_groups.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr double bytes_per_mb = 1024.0 * 1024.0;

/// Where a hierarchy of groups is mounted.
struct Hierarchy
{
    fs::path group;  ///< The group that stands at the mount point: in a container, not the topmost.
    fs::path mount_point;
};

/// "\040" stands for a blank.
std::string unescaped(const std::string& text)
{
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i)
        if (text[i] == '\\' && i + 3 < text.size())
        {
            result += static_cast<char>((text[i + 1] - '0') * 64 + (text[i + 2] - '0') * 8 + (text[i + 3] - '0'));
            i += 3;
        }
        else
            result += text[i];
    return result;
}

bool lists(const std::string& names, const std::string& name)
{
    return ("," + names + ",").find("," + name + ",") != std::string::npos;
}

/// Of the version 2 where `controller` is empty.
std::optional<Hierarchy> hierarchy(const fs::path& proc, const std::string& controller)
{
    std::ifstream mounts(proc / "mountinfo");
    for (std::string line; std::getline(mounts, line);)
    {
        // "36 35 98:0 /group /mount/point rw,noatime shared:1 - cgroup cgroup rw,memory"
        std::istringstream words(line);
        std::string id, parent, device, group, point, word, kind, source, options;
        words >> id >> parent >> device >> group >> point;
        while (words >> word && word != "-")
            continue;
        words >> kind >> source >> options;
        if (controller.empty() ? kind == "cgroup2" : kind == "cgroup" && lists(options, controller))
            return Hierarchy{unescaped(group), unescaped(point)};
    }
    return std::nullopt;
}

/// The group of the process, as its hierarchy names it.
std::optional<fs::path> group_of(const fs::path& proc, const std::string& controller)
{
    std::ifstream groups(proc / "cgroup");
    for (std::string line; std::getline(groups, line);)
    {
        // "4:memory:/job_7", of the version 2 "0::/job_7"
        const std::size_t first = line.find(':');
        const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
        if (second == std::string::npos)
            continue;
        const std::string names = line.substr(first + 1, second - first - 1);
        if (controller.empty() ? names.empty() : lists(names, controller))
            return fs::path(line.substr(second + 1));
    }
    return std::nullopt;
}

/// The folders of the group and of those above it, as far as they can be seen.
std::vector<fs::path> folders(const fs::path& proc, const fs::path& root, const std::string& controller)
{
    const auto mounted = hierarchy(proc, controller);
    const auto group = group_of(proc, controller);
    if (!mounted || !group)
        return {};
    const fs::path top = root / mounted->mount_point.relative_path();
    fs::path below = group->lexically_relative(mounted->group);
    // A group outside what is mounted here is seen as the topmost.
    if (below.empty() || *below.begin() == ".." || *below.begin() == ".")
        below.clear();
    std::vector<fs::path> result{top};
    for (const fs::path& name : below)
        result.push_back(result.back() / name);
    return result;
}

/// Nothing for "max" and what is not there.
std::optional<double> number_in(const fs::path& file)
{
    std::ifstream stream(file);
    double number = 0;
    return stream >> number && number >= 0 ? std::optional(number) : std::nullopt;
}

void narrow_memory(ControlGroupLimits& limits, std::optional<double> most, std::optional<double> used)
{
    if (!most)
        return;
    limits.memory_mb = std::min(limits.memory_mb, *most / bytes_per_mb);
    limits.free_memory_mb = std::min(limits.free_memory_mb, std::max(0.0, *most - used.value_or(0)) / bytes_per_mb);
}

void narrow_cores(ControlGroupLimits& limits, std::optional<double> quota, std::optional<double> period)
{
    if (quota && period && *quota > 0 && *period > 0)
        limits.cores = std::min(limits.cores, *quota / *period);
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

}  // namespace fresco::host

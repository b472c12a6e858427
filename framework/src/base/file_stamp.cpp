#include "base/file_stamp.h"
#include "base/glob.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/hash.h>
#include <fresco/input_roots.h>

#include <algorithm>
#include <ctime>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <vector>

namespace fresco::host
{
namespace
{

std::string names_hash(const std::filesystem::path& folder, const std::string& pattern)
{
    std::vector<std::string> names;
    std::error_code error;
    std::filesystem::directory_iterator entries(folder, error);
    if (error)
        throw MissingInput(folder.string() + ": cannot list the folder: " + error.message());
    for (const auto& entry : entries)
        if (std::string name = entry.path().filename().string(); name_matches(name, pattern))
            names.push_back(std::move(name));
    std::sort(names.begin(), names.end());
    std::string joined;
    for (const auto& name : names)
        joined += name + '\0';
    return content_hash(joined);
}

std::string contents_of(const std::filesystem::path& path, bool folder)
{
    return folder ? names_hash(path.parent_path(), path.filename().string()) : file_hash(path);
}

/// The file or folder on the disk.
std::filesystem::path place_of(const std::filesystem::path& path, bool folder)
{
    return folder ? path.parent_path() : path;
}

std::int64_t nanoseconds(const timespec& time)
{
    return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

/// The stamp where it is old enough to be relied on. Call it before reading the contents.
std::optional<FileStamp> settled(const FileStamp& stamp)
{
    // The coarsest file systems (FAT) count in two seconds.
    constexpr std::int64_t coarsest_step_ns = 2'000'000'000;
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    if (std::max(stamp.mtime_ns, stamp.ctime_ns) > nanoseconds(now) - coarsest_step_ns)
        return std::nullopt;
    return stamp;
}

Value to_value(const FileStamp& stamp)
{
    return Value::List{static_cast<std::int64_t>(stamp.size), stamp.mtime_ns, stamp.ctime_ns,
                       static_cast<std::int64_t>(stamp.inode), static_cast<std::int64_t>(stamp.device)};
}

FileStamp stamp_from(const Value& value)
{
    const auto& list = value.as_list();
    if (list.size() != 5)
        throw Error("a stamp has 5 entries, this one " + std::to_string(list.size()));
    return {static_cast<std::uint64_t>(list[0].as_int()), list[1].as_int(), list[2].as_int(),
            static_cast<std::uint64_t>(list[3].as_int()), static_cast<std::uint64_t>(list[4].as_int())};
}

}  // namespace

/// Network file systems have another number on every machine, and after every boot: all that have no device of their own count as
/// one. Their numbers of files and times to the nanosecond tell files apart.
std::optional<FileStamp> stamp_of(const std::filesystem::path& file)
{
    struct stat status
    {
    };
    if (stat(file.c_str(), &status) != 0)
        return std::nullopt;
    return FileStamp{static_cast<std::uint64_t>(status.st_size), nanoseconds(status.st_mtim), nanoseconds(status.st_ctim),
                     status.st_ino, major(status.st_dev) == 0 ? 0 : status.st_dev};
}

Dependency take_dependency(const std::filesystem::path& path, bool folder)
{
    const auto now = stamp_of(place_of(path, folder));
    if (!now)
        throw MissingInput(place_of(path, folder).string() + ": no such " + (folder ? "folder" : "file"));
    const auto stamp = settled(*now);
    return {path, folder, stamp, contents_of(path, folder)};
}

Change compare(Dependency& dependency)
{
    const auto now = stamp_of(place_of(dependency.path, dependency.folder));
    if (!now)
        return Change::contents;
    if (dependency.stamp == now)
        return Change::none;
    try
    {
        const Dependency taken = take_dependency(dependency.path, dependency.folder);
        if (taken.hash != dependency.hash)
            return Change::contents;
        const bool renewed = taken.stamp != dependency.stamp;
        dependency.stamp = taken.stamp;
        return renewed ? Change::stamp : Change::none;
    }
    catch (const Error&)
    {
        return Change::contents;
    }
}

Value to_value(const Dependency& dependency)
{
    return Value::List{dependency.stored_name(), dependency.folder, dependency.stamp ? to_value(*dependency.stamp) : Value(),
                       Value(dependency.hash)};
}

Dependency dependency_from(const Value& value)
{
    const auto& list = value.as_list();
    if (list.size() != 4)
        throw Error("a dependency has 4 entries, this one " + std::to_string(list.size()));
    const std::string& name = list[0].as_string();
    Dependency dependency{input_path(name), list[1].as_bool(), std::nullopt, list[3].as_string(), name};
    if (!list[2].is_null())
        dependency.stamp = stamp_from(list[2]);
    return dependency;
}

namespace
{

/// Nothing for what another version of fresco wrote, or a pipeline with other inputs: such a file is read again.
std::optional<Dependency> usable_dependency(const Value& entry)
{
    try
    {
        return dependency_from(entry);
    }
    catch (const Error&)
    {
        return std::nullopt;
    }
}

}  // namespace

FileHashes::FileHashes(std::filesystem::path index) : index_(std::move(index))
{
    if (index_.empty())
        return;
    for (const Value& line : Journal(index_).read())
        if (const Value* files = line.find("files"); files != nullptr && files->is_list())
            for (const auto& entry : files->as_list())
                if (auto dependency = usable_dependency(entry))
                {
                    std::string path = dependency->path.string();
                    known_.insert_or_assign(std::move(path), std::move(*dependency));
                }
}

Dependency FileHashes::dependency(const std::filesystem::path& file)
{
    const auto known = known_.find(file.string());
    if (known != known_.end() && known->second.stamp && known->second.stamp == stamp_of(file))
        return known->second;
    Dependency taken = take_dependency(file, false);
    added_.insert(file.string());
    return known_.insert_or_assign(file.string(), std::move(taken)).first->second;
}

std::string FileHashes::hash(const std::filesystem::path& file)
{
    return dependency(file).hash;
}

void FileHashes::remember(const std::filesystem::path& file, const std::string& hash)
{
    if (const auto now = stamp_of(file))
    {
        known_.insert_or_assign(file.string(), Dependency{file, false, settled(*now), hash});
        added_.insert(file.string());
    }
}

Value::List FileHashes::entries(const std::set<std::string>* chosen) const
{
    Value::List entries;
    for (const auto& [path, dependency] : known_)
        if (dependency.stamp && (chosen == nullptr || chosen->contains(path)) && dependency.stamp == stamp_of(dependency.path))
            entries.push_back(to_value(dependency));
    return entries;
}

void FileHashes::save()
{
    if (index_.empty())
        return;
    try
    {
        if (auto added = entries(&added_); !added.empty())
            Journal(index_).add(Value::Map{{"files", std::move(added)}});
        added_.clear();
    }
    catch (const Error&)
    {
        return;
    }
}

void FileHashes::tidy() const
{
    constexpr std::size_t entries_per_line = 1000;
    const Value::List all = entries(nullptr);
    std::vector<Value> lines;
    for (std::size_t i = 0; i < all.size(); i += entries_per_line)
    {
        const auto begin = all.begin() + static_cast<std::ptrdiff_t>(i);
        const auto end = all.begin() + static_cast<std::ptrdiff_t>(std::min(i + entries_per_line, all.size()));
        lines.emplace_back(Value::Map{{"files", Value::List(begin, end)}});
    }
    Journal(index_).replace(lines);
}

}  // namespace fresco::host

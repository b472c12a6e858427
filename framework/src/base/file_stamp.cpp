#include "base/file_stamp.h"
#include "base/glob.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>

#include <algorithm>
#include <ctime>
#include <sys/stat.h>
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

}  // namespace

std::optional<FileStamp> stamp_of(const std::filesystem::path& file)
{
    struct stat status
    {
    };
    if (stat(file.c_str(), &status) != 0)
        return std::nullopt;
    const auto mtime = std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
    return FileStamp{static_cast<std::uint64_t>(status.st_size), mtime, status.st_ino};
}

FileStamp settled(FileStamp stamp)
{
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    const auto now_ns = std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
    if (stamp.mtime_ns > now_ns - 2'000'000'000)
        stamp.mtime_ns = 0;
    return stamp;
}

Dependency take_dependency(const std::filesystem::path& path, bool folder)
{
    const auto before = stamp_of(place_of(path, folder));
    if (!before)
        throw MissingInput(place_of(path, folder).string() + ": no such " + (folder ? "folder" : "file"));
    return {path, folder, settled(*before), contents_of(path, folder)};
}

Change compare(Dependency& dependency)
{
    const auto now = stamp_of(place_of(dependency.path, dependency.folder));
    if (!now)
        return Change::contents;
    if (dependency.stamp.matches(*now))
        return Change::none;
    try
    {
        const Dependency taken = take_dependency(dependency.path, dependency.folder);
        if (taken.hash != dependency.hash)
            return Change::contents;
        dependency.stamp = taken.stamp;
        return Change::stamp;
    }
    catch (const Error&)
    {
        return Change::contents;
    }
}

Value to_value(const Dependency& dependency)
{
    return Value::List{dependency.path.string(),  dependency.folder,      dependency.stamp.size,
                       dependency.stamp.mtime_ns, dependency.stamp.inode, Value(dependency.hash)};
}

Dependency dependency_from(const Value& value)
{
    const auto& list = value.as_list();
    if (list.size() != 6)
        throw Error("a dependency has 6 entries, this one " + std::to_string(list.size()));
    return {list[0].as_string(),
            list[1].as_bool(),
            {static_cast<std::uint64_t>(list[2].as_int()), list[3].as_int(), static_cast<std::uint64_t>(list[4].as_int())},
            list[5].as_string()};
}

FileHashes::FileHashes(std::filesystem::path index) : index_(std::move(index))
{
    try
    {
        if (!std::filesystem::exists(index_))
            return;
        const Value entries = parse_json(read_text_file(index_, std::size_t{1} << 30U), index_.string());
        for (const auto& entry : entries.as_list())
        {
            Dependency dependency = dependency_from(entry);
            std::string path = dependency.path.string();
            known_.insert_or_assign(std::move(path), std::move(dependency));
        }
    }
    catch (const Error&)
    {
        known_.clear();
    }
}

Dependency FileHashes::dependency(const std::filesystem::path& file)
{
    const auto known = known_.find(file.string());
    if (known != known_.end())
    {
        const auto now = stamp_of(file);
        if (now && known->second.stamp.matches(*now))
            return known->second;
    }
    Dependency taken = take_dependency(file, false);
    changed_ = true;
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
        changed_ = true;
    }
}

void FileHashes::save()
{
    if (!changed_)
        return;
    Value::List entries;
    for (const auto& [path, dependency] : known_)
        if (std::filesystem::exists(dependency.path))
            entries.push_back(to_value(dependency));
    try
    {
        write_file(index_, to_json(Value(std::move(entries))));
        changed_ = false;
    }
    catch (const Error&)
    {
        return;
    }
}

}  // namespace fresco::host

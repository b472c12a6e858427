#include "base/file_stamp.h"
#include "base/common.h"
#include "base/file_contents.h"
#include "base/glob.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <fstream>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <sys/statvfs.h>
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
    std::ranges::sort(names);
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

/// In the words of statfs(2). Lustre, GPFS, BeeGFS and CephFS have servers of their own; NFS and SMB show those of others.
constexpr std::array<std::int64_t, 17> own_ctime{
    0xEF53,      // ext2, ext3, ext4
    0x58465342,  // XFS
    0x9123683E,  // Btrfs
    0xF2F52010,  // F2FS
    0x01021994,  // tmpfs
    0x858458F6,  // ramfs
    0x2FC12FC1,  // ZFS
    0xCA451A4E,  // bcachefs
    0x3153464A,  // JFS
    0x52654973,  // ReiserFS
    0x3434,      // NILFS
    0x7461636F,  // OCFS2
    0x01161970,  // GFS2
    0x0BD00BD0,  // Lustre
    0x47504653,  // GPFS
    0x19830326,  // BeeGFS
    0x00C36400,  // CephFS
};

struct FileSystem
{
    std::int64_t type = 0;
    std::int64_t id = 0;
    bool read_only = false;
};

/// A read-only view of a folder, as a container has it, does not make the file system read-only. In /proc/self/mountinfo its own
/// options come last: "36 35 98:0 /data /in ro,noatime - ext4 /dev/sda1 rw,errors=continue".
bool is_mounted_for_writing(dev_t device)
{
    const std::string number = " " + std::to_string(major(device)) + ":" + std::to_string(minor(device)) + " ";
    std::ifstream mounts("/proc/self/mountinfo");
    for (std::string line; std::getline(mounts, line);)
        if (line.find(number) != std::string::npos && (line + ",").find(" rw,", line.rfind(' ')) != std::string::npos)
            return true;
    return false;
}

/// A file system that does not answer is unknown. Network file systems ask their server each time, so an answer holds
/// for all files of a device, for a second: another may be mounted in its place.
FileSystem file_system_of(const std::filesystem::path& file, dev_t device)
{
    struct Answer
    {
        FileSystem file_system;
        std::chrono::steady_clock::time_point end;
    };
    thread_local std::map<dev_t, Answer> answers;
    Answer& answer = answers[device];
    const auto now = std::chrono::steady_clock::now();
    if (now < answer.end)
        return answer.file_system;
    struct statfs status = {};
    if (statfs(file.c_str(), &status) != 0)
        return {};
    const bool read_only = (status.f_flags & ST_RDONLY) != 0 && !is_mounted_for_writing(device);
    answer = {{status.f_type, std::bit_cast<std::int64_t>(status.f_fsid), read_only}, now + std::chrono::seconds(1)};
    return answer.file_system;
}

struct Seen
{
    FileStamp stamp;
    bool read_only = false;
};

/// Network file systems have another number on every machine, and after every boot: all that have no device of their own count as
/// one. Their numbers of files and times to the nanosecond tell files apart.
std::optional<Seen> look_at(const std::filesystem::path& file)
{
    struct stat status = {};
    if (stat(file.c_str(), &status) != 0)
        return std::nullopt;
    const FileSystem file_system = file_system_of(file, status.st_dev);
    const bool has_device = major(status.st_dev) != 0;
    return Seen{{status.st_size, nanoseconds(status.st_mtim), nanoseconds(status.st_ctim),
                 static_cast<std::int64_t>(status.st_ino), has_device ? static_cast<std::int64_t>(status.st_dev) : 0,
                 file_system.type, has_device ? file_system.id : 0},
                file_system.read_only};
}

/// The stamp where it tells changes and is old enough to be relied on. Call it before reading the contents.
std::optional<FileStamp> reliable(const std::optional<Seen>& seen)
{
    // The coarsest file systems (FAT) count in two seconds.
    constexpr std::int64_t coarsest_step_ns = 2'000'000'000;
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    if (!seen || !tells_changes(seen->stamp, seen->read_only) ||
        std::max(seen->stamp.mtime_ns, seen->stamp.ctime_ns) > nanoseconds(now) - coarsest_step_ns)
        return std::nullopt;
    return seen->stamp;
}

bool is_as(const std::optional<FileStamp>& known, const std::filesystem::path& place)
{
    return known && known == reliable(look_at(place));
}

Value to_value(const FileStamp& stamp)
{
    return Value::List{stamp.size,   stamp.mtime_ns,    stamp.ctime_ns,      stamp.inode,
                       stamp.device, stamp.file_system, stamp.file_system_id};
}

/// Returns nothing for the stamp of another version of fresco: the contents are read once more.
std::optional<FileStamp> stamp_from(const Value& value)
{
    const auto& list = value.as_list();
    if (list.size() != 7)
        return std::nullopt;
    const std::vector<std::int64_t> numbers = each(list, &Value::as_int);
    return FileStamp{numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5], numbers[6]};
}

}  // namespace

std::optional<FileStamp> stamp_of(const std::filesystem::path& file)
{
    const auto seen = look_at(file);
    return seen ? std::optional(seen->stamp) : std::nullopt;
}

bool tells_changes(const FileStamp& stamp, bool read_only)
{
    constexpr std::int64_t second_ns = 1'000'000'000;
    return (!read_only && std::ranges::count(own_ctime, stamp.file_system) != 0) ||
           (stamp.ctime_ns != stamp.mtime_ns && stamp.ctime_ns % second_ns != 0);
}

Dependency take_dependency(const std::filesystem::path& path, bool folder)
{
    const auto now = look_at(place_of(path, folder));
    if (!now)
    {
        const std::string reason = unreachable_text(errno);
        throw MissingInput(place_of(path, folder).string() + ": " +
                           (reason.empty() ? std::string("no such ") + (folder ? "folder" : "file") : reason));
    }
    const auto stamp = reliable(now);
    return {path, folder, stamp, contents_of(path, folder)};
}

Change compare(Dependency& dependency)
{
    if (is_as(dependency.stamp, place_of(dependency.path, dependency.folder)))
        return Change::none;
    const auto taken = attempt([&] { return take_dependency(dependency.path, dependency.folder); });
    if (!taken || taken->hash != dependency.hash)
        return Change::contents;
    const bool renewed = taken->stamp != dependency.stamp;
    dependency.stamp = taken->stamp;
    return renewed ? Change::stamp : Change::none;
}

Value to_value(const Dependency& dependency)
{
    return Value::List{dependency.path.string(), dependency.folder, dependency.stamp ? to_value(*dependency.stamp) : Value(),
                       Value(dependency.hash)};
}

Dependency dependency_from(const Value& value)
{
    const auto& list = value.as_list();
    if (list.size() != 4)
        throw Error("a dependency has 4 entries, this one " + std::to_string(list.size()));
    Dependency dependency{list[0].as_string(), list[1].as_bool(), std::nullopt, list[3].as_string()};
    if (!list[2].is_null())
        dependency.stamp = stamp_from(list[2]);
    return dependency;
}

FileHashes::FileHashes(std::filesystem::path index) : index_(std::move(index))
{
    if (index_.empty())
        return;
    for (const Value& line : Journal(index_).read())
        if (const Value* files = line.find("files"); files != nullptr && files->is_list())
            for (const auto& entry : files->as_list())
                // Another version of fresco may have written it: such a file is read again.
                if (auto dependency = attempt([&] { return dependency_from(entry); }))
                {
                    std::string path = dependency->path.string();
                    known_.insert_or_assign(std::move(path), std::move(*dependency));
                }
}

Dependency FileHashes::dependency(const std::filesystem::path& file)
{
    const auto known = known_.find(file.string());
    if (known != known_.end() && is_as(known->second.stamp, file))
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
    if (const auto now = look_at(file))
    {
        known_.insert_or_assign(file.string(), Dependency{file, false, reliable(now), hash});
        added_.insert(file.string());
    }
}

Value::List FileHashes::entries(const std::set<std::string>* chosen) const
{
    Value::List entries;
    for (const auto& [path, dependency] : known_)
        if ((chosen == nullptr || chosen->contains(path)) && is_as(dependency.stamp, dependency.path))
            entries.push_back(to_value(dependency));
    return entries;
}

void FileHashes::save()
{
    if (index_.empty())
        return;
    auto added = entries(&added_);
    if (added.empty() || attempt([&] { Journal(index_).add(Value::Map{{"files", std::move(added)}}); }))
        added_.clear();
}

void FileHashes::tidy() const
{
    Journal(index_).replace(each(entries(nullptr),
                                 [](const Value& entry) {
                                     return Value(Value::Map{{"files", Value::List{entry}}});
                                 }));
}

}  // namespace fresco::host

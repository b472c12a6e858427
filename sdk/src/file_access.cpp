#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/file_access.h>

#include <algorithm>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <memory>
#include <mutex>
#include <string_view>
#include <unistd.h>
#include <utility>

namespace fresco
{
namespace fs = std::filesystem;
namespace
{

struct GuardedFolder
{
    std::string name;
    std::string real;  ///< The name without links.
    std::string advice;
};

std::mutex guard_mutex;
std::vector<GuardedFolder> guarded_folders;

std::string without_slash(const fs::path& folder)
{
    return folder.has_filename() ? folder.native() : folder.parent_path().native();
}

/// The advice of the guarded folder that is the path or holds it. Replaces its name in the path by its real one.
std::optional<std::string> guard(fs::path& path)
{
    const std::string text = path.native();
    const std::lock_guard lock(guard_mutex);
    for (const auto& [name, real, advice] : guarded_folders)
        if (text.starts_with(name) && (text.size() == name.size() || text[name.size()] == '/'))
        {
            path = real + text.substr(name.size());
            return advice;
        }
    return std::nullopt;
}

std::string_view kind_text(mode_t mode)
{
    static constexpr std::pair<mode_t, std::string_view> kinds[] = {
        {S_IFREG, "a file"}, {S_IFDIR, "a folder"}, {S_IFLNK, "a symbolic link"}, {S_IFIFO, "a FIFO"}, {S_IFSOCK, "a socket"}};
    for (const auto& [kind, text] : kinds)
        if ((mode & S_IFMT) == kind)
            return text;
    return "a device";
}

[[noreturn]] void refuse(const fs::path& path, mode_t found, bool is_folder, const std::string& advice)
{
    throw Error(path.string() + ": is " + std::string(kind_text(found)) + " in place of a " + (is_folder ? "folder" : "file") +
                ": " + advice);
}

/// Opens a folder step by step, so that no link is followed: openat2 does it in one call, but not before Linux 5.6 nor in every
/// container. Throws Error naming the first step that is no folder; one that is missing is left in errno.
FileDescriptor open_guarded(const fs::path& folder, const std::string& advice)
{
    if (std::ranges::find(folder, fs::path("..")) != folder.end())
        throw Error(folder.string() + ": leads out of its folder by '..'");
    constexpr int flags = O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
    FileDescriptor fd(uninterrupted([&] { return open("/", flags); }));
    fs::path reached = "/";
    for (const fs::path& step : folder.relative_path())
    {
        if (!fd.valid())
            break;
        FileDescriptor next(uninterrupted([&] { return openat(fd.get(), step.c_str(), flags); }));
        const int cause = errno;
        struct stat status = {};
        reached /= step;
        if (!next.valid() && fstatat(fd.get(), step.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && !S_ISDIR(status.st_mode))
            refuse(reached, status.st_mode, true, advice);
        fd = std::move(next);
        errno = cause;
    }
    return fd;
}

using OpenedFolder = std::unique_ptr<DIR, int (*)(DIR*)>;

OpenedFolder list_folder(int folder, const char* name, int more_flags)
{
    FileDescriptor fd(uninterrupted([&] { return openat(folder, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC | more_flags); }));
    OpenedFolder opened(fd.valid() ? fdopendir(fd.get()) : nullptr, &closedir);
    if (opened)
        (void)fd.release();
    return opened;
}

/// The next name but "." and ".."; null at the end, with errno set if it is not the end.
const char* next_name(DIR* folder)
{
    for (;;)
    {
        errno = 0;
        const dirent* entry = readdir(folder);
        if (entry == nullptr)
            return nullptr;
        if (const std::string_view name = entry->d_name; name != "." && name != "..")
            return entry->d_name;
    }
}

/// A program may have made a folder that even its owner may not list or change. The owner may allow it again.
void allow_owner(int folder, const char* name)
{
    const FileDescriptor fd(uninterrupted([&] { return openat(folder, name, O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC); }));
    struct stat status = {};
    if (fd.valid() && fstat(fd.get(), &status) == 0 && (status.st_mode & S_IRWXU) != S_IRWXU)
        chmod(("/proc/self/fd/" + std::to_string(fd.get())).c_str(), S_IRWXU);
}

bool remove_in(int folder, const char* name)
{
    if (unlinkat(folder, name, 0) == 0 || errno == ENOENT)
        return true;
    if (errno != EISDIR && errno != EPERM)
        return false;
    allow_owner(folder, name);
    {
        const OpenedFolder opened = list_folder(folder, name, O_NOFOLLOW);
        if (!opened)
            return errno == ENOENT;
        while (const char* below = next_name(opened.get()))
            if (!remove_in(dirfd(opened.get()), below))
                return false;
        if (errno != 0)
            return false;
    }
    return unlinkat(folder, name, AT_REMOVEDIR) == 0 || errno == ENOENT;
}

void sync_opened(const fs::path& path, int flags)
{
    const FileDescriptor fd = open_file(path, O_RDONLY | flags);
    if (!fd.valid() || uninterrupted([&] { return fsync(fd.get()); }) != 0)
        throw Error(path.string() + ": cannot be written to the disk: " + std::strerror(errno));
}

}  // namespace

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept
{
    if (this != &other)
    {
        reset();
        fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
}

void FileDescriptor::reset()
{
    if (fd_ >= 0)
        ::close(fd_);
    fd_ = -1;
}

std::string detail::cause_of(int error, const fs::path& path)
{
    const std::string name = path.filename();
    const std::size_t refused = name.find_first_of("\"*:<>?\\|");
    std::string text = std::strerror(error);
    // The exFAT of FUSE says that there is no such file.
    const bool may_be_name = error == EINVAL || (error == ENOENT && is_folder(path.parent_path()));
    if (may_be_name && refused != std::string::npos)
        text += std::string(": this file system takes no '") + name[refused] + "' in names; choose another name, or another disk";
    return text;
}

void forbid_links_below(const fs::path& folder, const std::string& advice)
{
    std::error_code error;
    const std::string real = without_slash(fs::weakly_canonical(folder, error));
    if (error)
        throw Error(folder.string() + ": cannot be used: " + error.message() + "; " + advice);
    const std::lock_guard lock(guard_mutex);
    for (const std::string& name : {without_slash(folder.lexically_normal()), real})
        if (std::ranges::find(guarded_folders, name, &GuardedFolder::name) == guarded_folders.end())
            guarded_folders.push_back({name, real, advice});
}

PathEntry::PathEntry(const fs::path& path) : path_(path), advice_(guard(path_)), name_(path_)
{
    if (!advice_)
        return;
    name_ = path_.has_filename() ? path_.filename() : ".";
    folder_ = open_guarded(path_.parent_path(), *advice_);
}

int PathEntry::folder() const
{
    return guarded() ? folder_.get() : AT_FDCWD;
}

void PathEntry::check_kind(bool is_folder) const
{
    struct stat status = {};
    if (!guarded() || !valid() || fstatat(folder(), name(), &status, AT_SYMLINK_NOFOLLOW) != 0)
        return;
    if (is_folder ? !S_ISDIR(status.st_mode) : !S_ISREG(status.st_mode))
        refuse(path_, status.st_mode, is_folder, *advice_);
    if (!is_folder && status.st_nlink > 1)
        throw Error(path_.string() + ": has a second name, a hard link: " + *advice_);
}

FileDescriptor open_file(const fs::path& file, int flags, mode_t mode)
{
    const PathEntry entry(file);
    if (!entry.valid())
        return {};
    const bool guarded = entry.guarded();
    const bool is_folder = (flags & O_DIRECTORY) != 0;
    // A file is truncated only once it is known to be the right one.
    const int cut = guarded ? flags & O_TRUNC : 0;
    const int all = (flags & ~cut) | O_CLOEXEC | O_NONBLOCK | (guarded ? O_NOFOLLOW : 0);
    FileDescriptor fd(uninterrupted([&] { return openat(entry.folder(), entry.name(), all, mode); }));
    if (!guarded)
        return fd;
    const int cause = errno;
    struct stat status = {};
    const bool writes = (flags & O_ACCMODE) != O_RDONLY;
    if (!fd.valid() || fstat(fd.get(), &status) != 0 || S_ISDIR(status.st_mode) != is_folder ||
        !(is_folder || S_ISREG(status.st_mode)) || (writes && status.st_nlink > 1))
        entry.check_kind(is_folder);
    if (fd.valid() && cut != 0 && uninterrupted([&] { return ftruncate(fd.get(), 0); }) != 0)
        return {};
    errno = cause;
    return fd;
}

std::optional<struct stat> path_status(const fs::path& path)
{
    try
    {
        const PathEntry entry(path);
        struct stat status = {};
        if (entry.valid() && fstatat(entry.folder(), entry.name(), &status, entry.guarded() ? AT_SYMLINK_NOFOLLOW : 0) == 0)
            return status;
    }
    catch (const Error&)
    {
        errno = ELOOP;
    }
    return std::nullopt;
}

bool is_file(const fs::path& path)
{
    const auto status = path_status(path);
    return status && S_ISREG(status->st_mode);
}

bool is_folder(const fs::path& path)
{
    const auto status = path_status(path);
    return status && S_ISDIR(status->st_mode);
}

std::vector<fs::path> entries_of(const fs::path& folder)
{
    std::vector<fs::path> entries;
    const PathEntry entry(folder);
    const OpenedFolder opened = entry.valid() ? list_folder(entry.folder(), entry.name(), entry.guarded() ? O_NOFOLLOW : 0)
                                              : OpenedFolder(nullptr, &closedir);
    if (!opened)
        entry.check_kind(true);
    else
        while (const char* name = next_name(opened.get()))
            entries.push_back(folder / name);
    if (errno != 0 && errno != ENOENT)
        throw Error(folder.string() + ": cannot be listed: " + std::strerror(errno));
    std::sort(entries.begin(), entries.end());
    return entries;
}

void make_folder(const fs::path& folder)
{
    if (folder.empty() || is_folder(folder))
        return;
    make_folder(folder.parent_path());
    const PathEntry entry(folder);
    entry.check_kind(true);
    if (!entry.valid() || (mkdirat(entry.folder(), entry.name(), 0777) != 0 && errno != EEXIST))
        throw Error(folder.string() + ": cannot make the folder: " + detail::cause_of(errno, folder));
    if (!is_folder(folder))
        throw Error(folder.string() + ": cannot make the folder: " + std::strerror(ENOTDIR));
    sync_folder(folder.has_parent_path() ? folder.parent_path() : ".");
}

bool make_link(const fs::path& target, const fs::path& link)
{
    const PathEntry entry(link);
    if (!entry.valid())
        return false;
    unlinkat(entry.folder(), entry.name(), 0);
    return symlinkat(target.c_str(), entry.folder(), entry.name()) == 0;
}

bool rename_path(const fs::path& from, const fs::path& to)
{
    const PathEntry old_entry(from);
    const PathEntry new_entry(to);
    return old_entry.valid() && new_entry.valid() &&
           renameat(old_entry.folder(), old_entry.name(), new_entry.folder(), new_entry.name()) == 0;
}

bool remove_path(const fs::path& path)
{
    const PathEntry entry(path);
    return entry.valid() ? remove_in(entry.folder(), entry.name()) : errno == ENOENT;
}

void sync_file(const fs::path& file)
{
    sync_opened(file, 0);
}

void sync_folder(const fs::path& folder)
{
    sync_opened(folder, O_DIRECTORY);
}

}  // namespace fresco

#pragma once

#include <cerrno>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <sys/stat.h>
#include <sys/types.h>
#include <utility>
#include <vector>

/// File system calls for the host, and the rule that makes them safe in folders that others can write to.
///
/// A store, an output folder and a task folder may be shared, unpacked from an archive, or contain a careless link. A symbolic
/// link in place of one of their files or folders would turn a write, a truncation or a removal against files elsewhere. The host
/// therefore names these folders once (`forbid_links_below`), and every function here and in files_io.h opens what lies below
/// them one step at a time, without following links. There is no moment between a check and its use.

namespace fresco
{

/// Makes a system call, again as long as a signal interrupts it. Not for close: Linux has closed the descriptor by then.
template <class Call>
auto uninterrupted(const Call& call)
{
    for (;;)
        if (const auto result = call(); result >= 0 || errno != EINTR)
            return result;
}

/// Owns a file descriptor; -1 = none.
class FileDescriptor
{
  public:
    FileDescriptor() = default;
    explicit FileDescriptor(int fd) : fd_(fd) {}
    ~FileDescriptor() { reset(); }
    FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept;
    FileDescriptor(const FileDescriptor&) = delete;
    FileDescriptor& operator=(const FileDescriptor&) = delete;

    int get() const { return fd_; }
    bool valid() const { return fd_ >= 0; }
    void reset();
    /// Gives it up: somebody else closes it.
    int release() { return std::exchange(fd_, -1); }

  private:
    int fd_ = -1;
};

/// From now on, the functions here and in files_io.h throw Error at a symbolic link below `folder`, an absolute path that need
/// not exist yet. The error names the link and ends with `advice`: "choose another store with --store". Links in the path of
/// `folder` itself are the user's choice, and are resolved now, once. For the rest of the process; thread-safe.
void forbid_links_below(const std::filesystem::path& folder, const std::string& advice);

/// A path for system calls whose names end in "at": where links are forbidden, its opened folder and its name in it.
class PathEntry
{
  public:
    /// If the folder cannot be opened, valid() is false and errno says why. Throws Error if a forbidden link is on the way.
    explicit PathEntry(const std::filesystem::path& path);
    bool guarded() const { return advice_.has_value(); }
    bool valid() const { return !guarded() || folder_.valid(); }
    int folder() const;
    const char* name() const { return name_.c_str(); }
    /// Throws Error unless links may be followed here, or the name is free or that of a regular file without a second name, a
    /// hard link (`is_folder`: of a folder).
    void check_kind(bool is_folder) const;

  private:
    std::filesystem::path path_;
    std::optional<std::string> advice_;  ///< Advice for errors, if links are forbidden.
    FileDescriptor folder_;
    std::string name_;
};

/// open(2), close-on-exec; never waits for the other end of a FIFO. If the file cannot be opened, the descriptor is not valid and
/// errno says why. Where links are forbidden, throws Error for anything but a regular file (with O_DIRECTORY, a folder), and for
/// a file to be written that has a second name (a hard link).
FileDescriptor open_file(const std::filesystem::path& file, int flags, mode_t mode = 0666);
/// stat(2); of a forbidden link, its own. Nothing, with errno set, if the path does not exist, cannot be looked at, or leads over
/// a forbidden link.
std::optional<struct stat> path_status(const std::filesystem::path& path);
/// Whether there is a regular file, or a folder. False for a forbidden link.
bool is_file(const std::filesystem::path& path);
bool is_folder(const std::filesystem::path& path);
/// The paths of what is directly in a folder, sorted; none if it does not exist. Throws Error if it cannot be listed.
std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder);
/// Makes a folder and those above it that are missing, and flushes their names to the disk. Throws Error naming the folder that
/// cannot be made.
void make_folder(const std::filesystem::path& folder);
/// Makes a symbolic link, in place of an older one. False, with errno set, if that fails.
bool make_link(const std::filesystem::path& target, const std::filesystem::path& link);
/// rename(2). False, with errno set, if that fails.
bool rename_path(const std::filesystem::path& from, const std::filesystem::path& to);
/// Removes a file, a link (never what it leads to), or a folder with all that is in it. False, with errno set, if something
/// stays. Throws Error if a forbidden link is on the way.
bool remove_path(const std::filesystem::path& path);
/// Flushes a file's data, or a folder's names, to the disk. Throws Error.
void sync_file(const std::filesystem::path& file);
void sync_folder(const std::filesystem::path& folder);

}  // namespace fresco

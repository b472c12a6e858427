#pragma once

#include <fresco/value.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

/// \file Knows whether an input file changed without reading it where its stamp can be relied on, and by its contents where
/// not. Keys of results and the records of what a stage read use it.

namespace fresco::host
{

/// A cheap sign that a file is unchanged: whoever writes to it, gives it another name or sets its times changes `ctime_ns`, where
/// the file system keeps that time itself (see tells_changes).
struct FileStamp
{
    std::int64_t size = 0;
    std::int64_t mtime_ns = 0;
    std::int64_t ctime_ns = 0;
    std::int64_t inode = 0;
    std::int64_t device = 0;
    std::int64_t file_system = 0;     ///< statfs: f_type
    std::int64_t file_system_id = 0;  ///< f_fsid

    friend bool operator==(const FileStamp&, const FileStamp&) = default;
};

/// The stamp as it is now; nothing if there is no such file, or none that may be looked at.
std::optional<FileStamp> stamp_of(const std::filesystem::path& file);

/// May an equal stamp stand for equal contents? False where the file system may take the time of the last change from elsewhere:
/// images (squashfs, ISO 9660), FAT, FUSE and network mounts set it to the time of the contents, or to the second in which the
/// image was made. Two images mounted in turn then have equal stamps.
bool tells_changes(const FileStamp& stamp, bool read_only);

/// Something outside the store that a result was made from: a file's contents, or which names that match a pattern are directly
/// in a folder.
struct Dependency
{
    std::filesystem::path path;  ///< With `folder`, the folder and then the pattern (see name_matches): "scan/seq-*".
    bool folder = false;
    /// From before its contents were read. None where it does not tell changes, or the last change was less than two seconds
    /// before: the file may change once more within the same step of the file system's clock.
    std::optional<FileStamp> stamp;
    std::string hash;
};

/// Reads the file, or the folder that holds the names, now. Throws MissingInput if it is not there.
Dependency take_dependency(const std::filesystem::path& path, bool folder);

enum class Change
{
    none,
    stamp,    ///< The contents are the same; the dependency's stamp was renewed.
    contents  ///< Changed, or gone.
};
/// Compares with what is there now: the stamp first, contents only when it changed.
Change compare(Dependency& dependency);

Value to_value(const Dependency& dependency);
/// Throws Error unless the value is a dependency.
Dependency dependency_from(const Value& value);

/// Content hashes of files, remembered by stamp.
class FileHashes
{
  public:
    /// Loads the hashes of the Journal `index`, as far as it is whole: it is a cache. Empty: remembers nothing beyond this
    /// process.
    explicit FileHashes(std::filesystem::path index);

    /// The file's content hash. Throws MissingInput if it cannot be read.
    std::string hash(const std::filesystem::path& file);
    /// Hash of a file with the stamp that it belongs to.
    Dependency dependency(const std::filesystem::path& file);
    /// Remembers a hash that is known without reading the file.
    void remember(const std::filesystem::path& file, const std::string& hash);
    /// Adds to the index what it does not hold yet. A failure to write it is ignored: the next run hashes again.
    void save();
    /// Writes the index again, without files that changed or are gone. Throws Error.
    void tidy() const;

  private:
    /// Entries of unchanged files, among those that `chosen` names, or all.
    Value::List entries(const std::set<std::string>* chosen) const;

    std::filesystem::path index_;
    std::map<std::string, Dependency> known_;
    std::set<std::string> added_;
};

}  // namespace fresco::host

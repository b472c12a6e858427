#pragma once

#include <fresco/value.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace fresco::host
{

/// What tells cheaply that a file is as it was. A file changed in the last two seconds gets mtime 0, which never matches: its
/// clock tick may not have passed yet, so the next comparison looks at the contents.
struct FileStamp
{
    std::uint64_t size = 0;
    std::int64_t mtime_ns = 0;
    std::uint64_t inode = 0;

    bool matches(const FileStamp& now) const { return mtime_ns != 0 && *this == now; }
    friend bool operator==(const FileStamp&, const FileStamp&) = default;
};

/// The stamp as it is now; nothing if there is no such file.
std::optional<FileStamp> stamp_of(const std::filesystem::path& file);
/// The same with mtime 0 where it is too young to be relied on.
FileStamp settled(FileStamp stamp);

/// Something outside the store that a result was made from: a file's contents, or which names that match a pattern are directly
/// in a folder.
struct Dependency
{
    std::filesystem::path path;  ///< With `folder`, the folder and then the pattern (see name_matches): "scan/seq-*".
    bool folder = false;
    FileStamp stamp;
    std::string hash;
};

/// Reads the file, or the folder that holds the names, now. Throws MissingInput if it is not there.
Dependency take_dependency(const std::filesystem::path& path, bool folder);

enum class Change
{
    none,
    stamp,    ///< Touched, but the contents are the same; the dependency's stamp was renewed.
    contents  ///< Changed, or gone.
};
/// Compares with what is there now: the stamp first, contents only when it changed.
Change compare(Dependency& dependency);

Value to_value(const Dependency& dependency);
/// Throws Error if the value is no dependency.
Dependency dependency_from(const Value& value);

/// Content hashes of files, remembered by stamp in an index file.
class FileHashes
{
  public:
    /// An unreadable index is started anew: it is a cache.
    explicit FileHashes(std::filesystem::path index);

    /// The file's content hash. Throws MissingInput if it cannot be read.
    std::string hash(const std::filesystem::path& file);
    /// The same with the stamp the hash belongs to.
    Dependency dependency(const std::filesystem::path& file);
    /// Remembers a hash that is known without reading the file.
    void remember(const std::filesystem::path& file, const std::string& hash);
    /// Writes the index if anything changed. A failure to write it is ignored: the next run hashes again.
    void save();

  private:
    std::filesystem::path index_;
    std::map<std::string, Dependency> known_;
    bool changed_ = false;
};

}  // namespace fresco::host

#pragma once

#include <fresco/value.h>

#include <filesystem>
#include <vector>

/// \file Small facts that the host writes down beside results: maps as lines of JSON that carry their checksum, so that damage is
/// found and costs time, never a wrong result.
///   write_record  one map, the whole file: manifests, keys, task ends. Durable.
///   Journal       many maps, appended by many processes: caches and statistics. May be lost.

namespace fresco::host
{

/// Writes a map as a line of JSON with the checksum of its text as the last entry, "checksum", as write_durable_file does. Throws
/// Error.
void write_record(const std::filesystem::path& file, const Value& map);
/// The map, with its checksum. Throws MissingInput if there is no such file, Error naming it if it is damaged.
Value read_record(const std::filesystem::path& file);

/// A file of checked lines that many processes add to, of one machine or several. Each line goes to the end under the file's
/// lock, so none is lost; a line cut by a crash is skipped. Not flushed to the disk.
class Journal
{
  public:
    explicit Journal(std::filesystem::path file) : file_(std::move(file)) {}

    /// The maps of all whole lines, oldest first; none if there is no such file.
    std::vector<Value> read() const;
    /// Throws Error naming the file if it cannot be written, or others hold its lock for two seconds.
    void add(const Value& map) const;
    /// Writes the file again with only these lines; those added since `read` are lost. Throws Error.
    void replace(const std::vector<Value>& maps) const;

  private:
    std::filesystem::path file_;
};

}  // namespace fresco::host

#pragma once

#include <fresco/value.h>

#include <filesystem>
#include <vector>

namespace fresco::host
{

/// A file of checked lines (see checked_line) that many processes add to, of one machine or several. Each line goes to the end
/// under the file's lock, so none is lost; one that was cut by a crash is passed over. Not flushed to the disk: for what may be
/// lost.
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

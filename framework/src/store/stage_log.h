#pragma once

#include "store/store.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

/// \file What a stage printed, kept with its result, to a megabyte. `fresco log` prints it.

namespace fresco::host
{

/// The log of the stage that made a key's result (Store::log_file), at most 1 MB. Write errors such as a full disk are
/// ignored: a log never ends a run.
class StageLog
{
  public:
    explicit StageLog(std::filesystem::path file) : file_(std::move(file)) {}

    /// Call when the stage starts. Truncates the file unless the stage resumes. Throws Error if something else is in its place.
    void begin(bool resumes);
    /// Adds a line as a terminal would finally show it, without the parts overwritten after a carriage return.
    void add(std::string_view line);
    /// Writes the added lines.
    void flush();

  private:
    void cut(std::string text);
    void write(std::string_view text);

    std::filesystem::path file_;
    FileDescriptor fd_;
    std::string added_;
    std::size_t size_ = 0;
    std::size_t head_ = 0;  ///< Bytes before the place where some were cut.
    std::size_t note_ = 0;  ///< Bytes of the line that says so.
    std::ptrdiff_t cut_lines_ = 0;
};

/// Says that the pipeline file's stage was last run, or found stored, with this key.
void link_stage_log(const Store& store, const std::filesystem::path& pipeline, const std::string& stage, const std::string& key);
/// Stage -> log, of all stages of the pipeline file that were run. A log may have been removed with its result.
std::map<std::string, std::filesystem::path> stage_logs(const Store& store, const std::filesystem::path& pipeline);

}  // namespace fresco::host

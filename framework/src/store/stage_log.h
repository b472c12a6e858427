#pragma once

#include "store/store.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace fresco::host
{

/// What a stage printed and said while it made the result of a key: Store::log_file, of a megabyte at most. What cannot be
/// written (a full disk) is lost in silence: no run ends because of it.
class StageLog
{
  public:
    explicit StageLog(std::filesystem::path file) : file_(std::move(file)) {}

    /// The stage runs: nothing is written before. The file begins anew, unless the stage resumes.
    void begin(bool resumes);
    /// A line as a terminal would show it in the end: a part that the program wrote over is left out.
    void add(std::string_view line);
    /// Writes what was added.
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
    std::size_t cut_lines_ = 0;
    std::size_t cut_bytes_ = 0;
};

/// Says that the pipeline file's stage was last run, or found stored, with this key.
void link_stage_log(const Store& store, const std::filesystem::path& pipeline, const std::string& stage, const std::string& key);
/// Stage -> log, of all stages of the pipeline file that were run. A log may have been removed with its result.
std::map<std::string, std::filesystem::path> stage_logs(const Store& store, const std::filesystem::path& pipeline);

}  // namespace fresco::host

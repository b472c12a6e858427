#pragma once

#include <fresco/run_context.h>
#include <fresco/value.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fresco
{

/// Finished pieces of a long stage's result, such as the views of a dataset, in a folder that outlives a killed run
/// (RunContext::checkpoint_folder): the next run makes only those that are missing. A piece is one or more files and a note that
/// is written after them, with their checksums. Thread-safe for different pieces.
class KeptPieces
{
  public:
    /// In the run's checkpoint folder, where it creates what it needs. The run must outlive it.
    explicit KeptPieces(RunContext& run);

    /// Where files are written, each whole or not at all (write_file). They stay until the checkpoint goes, which is after the
    /// result is in the store: whoever is killed while gigabytes are published loses no piece.
    std::filesystem::path folder() const { return checkpoint_ / "files"; }
    /// What the note of a piece says; nothing without a note. Where the note or a file that it names is gone or damaged, that
    /// is said in a warning, and the piece counts as not made.
    std::optional<Value> find(std::size_t piece) const;
    /// Says that a piece is finished: its files, by name below folder(), and what else is to be known of it. Throws Error.
    void note(std::size_t piece, const std::vector<std::string>& files, Value about) const;
    /// Gives files the same names below another folder too: links, or copies where the file system has none. Nobody may change
    /// them in place afterward. Throws Error naming the file.
    void link(const std::vector<std::string>& files, const std::filesystem::path& to) const;

  private:
    std::filesystem::path note_of(std::size_t piece) const;

    RunContext& run_;
    std::filesystem::path checkpoint_;
};

}  // namespace fresco

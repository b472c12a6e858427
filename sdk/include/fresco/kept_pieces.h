#pragma once

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
/// is written after them. Thread-safe for different pieces.
class KeptPieces
{
  public:
    /// `checkpoint`: of this result alone. Creates what it needs below it.
    explicit KeptPieces(std::filesystem::path checkpoint);

    /// Where files are written, each whole or not at all (write_file). They stay until the checkpoint goes, which is after the
    /// result is in the store: whoever is killed while gigabytes are published loses no piece.
    std::filesystem::path folder() const { return checkpoint_ / "files"; }
    /// What the note of a piece says; nothing if there is none, or a file that it names is gone or has another size.
    std::optional<Value> find(std::size_t piece) const;
    /// Says that a piece is finished: its files, by name below folder(), and what else is to be known of it. Throws Error.
    void note(std::size_t piece, const std::vector<std::string>& files, Value about) const;
    /// Gives files the same names below another folder too: links, or copies where the file system has none. Nobody may change
    /// them in place afterward. Throws Error naming the file.
    void link(const std::vector<std::string>& files, const std::filesystem::path& to) const;

  private:
    std::filesystem::path note_of(std::size_t piece) const;

    std::filesystem::path checkpoint_;
};

}  // namespace fresco

#pragma once

#include <fresco/parallel.h>
#include <fresco/value.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file What a stage can ask of the host while it runs: progress, messages, reports, folders, and pieces of a long result that a
/// killed run leaves to the next.

namespace fresco
{

/// The host, as a running stage sees it. All functions may be called from any thread. A number that is not finite may be given to
/// metric and report (also inside of lists and maps): it is kept and shown as null. A `progress` that is not finite is passed
/// over, such a total counts as unknown.
class RunContext : public Progress
{
  public:
    ~RunContext() override;
    /// A line for the person watching ("3 of 125 frames dropped: blurred").
    virtual void message(std::string_view text) = 0;
    /// Writes a message marked as a warning.
    virtual void warning(std::string_view text) = 0;
    /// The newest value of a running figure, shown in the live line ("loss").
    virtual void metric(std::string_view name, double value) = 0;
    /// An entry of the stage's report, kept in the result's manifest and printed by `--json`. Counts, shares, seconds.
    virtual void report(std::string_view key, Value value) = 0;
    /// How the result comes about, for a file that is passed on without the store: {versions, stages}, as described in
    /// pipelines/results.md. Only what determines the result: no times, no absolute paths. Empty in a test.
    virtual Value origin() const = 0;
    /// A file the person may look at while the stage runs; not part of the result.
    virtual std::filesystem::path preview_folder() = 0;
    /// An empty folder, removed when the stage ends.
    virtual std::filesystem::path scratch_folder() = 0;
    /// A folder that belongs to exactly this result and outlives a killed run; removed once the result is published. Write into
    /// it with write_checked, read with read_checked: files may be damaged over time.
    virtual std::filesystem::path checkpoint_folder() = 0;
    /// Says that the result depends on the contents of a file that no option of type InputFile names. The next run does nothing
    /// only if they are unchanged.
    virtual void reads_file(const std::filesystem::path& file) = 0;
    /// Says that the result depends on which names that match `names` are directly in a folder: '*' stands for any text, '?' for
    /// one character ("seq-*", "*.png"); a pattern without them for one name that is there or not. Name what the stage looks for
    /// and nothing else: results, an editor's files or pictures put beside it must not make it run again. Patterns add up,
    /// one call each. A stage that lists the folder must pass over all other names.
    virtual void reads_folder(const std::filesystem::path& folder, std::string_view names) = 0;
    /// Notes that the stage depends on all names in the folder.
    void reads_folder(const std::filesystem::path& folder) { reads_folder(folder, "*"); }
};

/// Finished pieces of a long stage's result, such as the views of a dataset, in a folder that outlives a killed run
/// (RunContext::checkpoint_folder): the next run makes only those that are missing. A piece is one or more files and a note that
/// is written after them, with their checksums. Thread-safe for different pieces.
class KeptPieces
{
  public:
    /// In the run's checkpoint folder, where it creates what it needs. The run must outlive it.
    explicit KeptPieces(RunContext& run);

    /// Folder for files, each written whole or not at all (write_file). They stay until the checkpoint goes, which is after the
    /// result is in the store: whoever is killed while gigabytes are published loses no piece.
    std::filesystem::path folder() const { return checkpoint_ / "files"; }
    /// The note of a finished piece. Empty if there is none or, with a warning, if the note or a file that it names is missing or
    /// damaged: the piece counts as not made.
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

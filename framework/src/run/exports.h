#pragma once

#include "base/file_stamp.h"
#include "pipeline/pipeline.h"
#include "run/output_record.h"
#include "store/store.h"
#include <fresco/files_io.h>

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// \file Copies what stages export to --out, and replaces nothing there that is not fresco's.

namespace fresco::host
{

/// The stage's outputs of type "files".
std::vector<std::string> files_outputs(const PipelineStage& stage);

/// Files by what they are, whatever name or link leads to them.
class KnownFiles
{
  public:
    void add(const std::filesystem::path& file);
    /// The path by which the same file was added; nothing if there is no such file, or it was not.
    std::optional<std::filesystem::path> find(const std::filesystem::path& file) const;

  private:
    using Id = std::pair<std::uintmax_t, std::uintmax_t>;  ///< Device and inode.
    std::map<Id, std::filesystem::path> by_id_;
    /// By the path in lower case: a mounted exFAT may show one file by two names with an inode for each.
    std::map<std::string, std::filesystem::path> by_name_;
};

/// The files that the pipeline's text and options name, which no output replaces.
std::vector<std::filesystem::path> named_inputs(const Pipeline& pipeline);
/// "is an input of this pipeline, …": how the error about such a file goes on.
inline constexpr const char* input_obstacle =
    "is an input of this pipeline, which no output replaces; choose another folder with --out";

/// Copies what stages made for the user to `--out`, each to its own place there.
class Exporter
{
  public:
    /// `replace`: outputs overwrite existing files, except inputs. The references must outlive the exporter.
    Exporter(const Store& store, const Pipeline& pipeline, std::filesystem::path out, FileHashes& hashes, bool replace = false);

    struct File
    {
        std::string stage;
        std::filesystem::path path;
        bool written = false;  ///< False: it was there already, with these contents.
    };

    /// Why the stage could not write its files, one by one, before it runs: a file of the user's, or of another pipeline's, is in
    /// the way. `object`: its result, if that is stored; empty: the files that its options name, and those of the last run.
    std::vector<std::string> obstacles(const PipelineStage& stage, const std::string& object);
    /// From now on no output replaces this file.
    void protect(const std::filesystem::path& input);
    bool is_input(const std::filesystem::path& file);

    /// Copies each file of the stage's result that is missing or different, whole or not at all; removes files that the stage
    /// wrote before and writes no longer, unless they were changed. Throws Error if a file cannot be written, is not fresco's to
    /// replace, or another stage wrote the same path; throws Damage if the store's copy is not what was written. Asks `stop`
    /// before each file, of which there may be thousands: where it says so, the rest is left to the next run.
    /// Returns the number of removed files.
    std::size_t copy(const PipelineStage& stage, const std::string& object, const std::function<bool()>& stop);
    const std::vector<File>& files() const { return files_; }
    /// The files of the stage's result that `copy` would write. Throws Error if their list cannot be read.
    std::set<std::string> missing(const PipelineStage& stage, const std::string& object) const;

  private:
    /// The files of one stage that are being copied.
    struct Batch
    {
        std::vector<File> found;
        std::vector<FileCopy> copies;
    };
    /// Makes the copies, and counts all that was found among the files. Empties the batch.
    void place(const PipelineStage& stage, OutputRecord& record, Batch& batch);
    std::size_t remove_stale(const PipelineStage& stage, OutputRecord& record, const std::set<std::string>& written);
    OutputOwner owner(const PipelineStage& stage) const;
    std::filesystem::path folder_of(const PipelineStage& stage) const;
    std::string obstacle(const PipelineStage& stage, const OutputRecord& record, const std::string& name);
    bool is_there(const std::filesystem::path& to, const std::filesystem::path& from) const;

    const Store& store_;
    const Pipeline& pipeline_;
    std::filesystem::path out_;
    FileHashes& hashes_;
    bool replace_;
    std::vector<File> files_;
    OutputOwners owners_;
    std::vector<std::filesystem::path> new_inputs_;  ///< Not among inputs_ yet.
    KnownFiles inputs_;
    KnownFiles exported_;
};

}  // namespace fresco::host

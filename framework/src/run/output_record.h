#pragma once

#include "base/file_stamp.h"
#include <fresco/value.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// \file Remembers which files of an output folder fresco wrote. Everything else there is the user's: a file that is not
/// recorded, that another pipeline wrote, or that changed since, is never replaced or removed.

namespace fresco::host
{

/// Identifies the writer of a file.
struct OutputOwner
{
    std::filesystem::path pipeline;  ///< Absolute.
    std::string combination;         ///< Combination of a matrix; empty: none.
    std::string stage;               ///< As the pipeline file names it; empty for reports.
    std::string output;              ///< The paths that the stage's options name, joined: another path leaves the old files.
};

/// The record of one folder, kept in the folder as `.fresco-outputs`. It names pipelines by their path from there, so that a
/// project can be moved. One thread; other runs may write to the same folder.
class OutputRecord
{
  public:
    /// Names are relative to `folder`, an absolute path. A damaged record counts as none. Throws Error if it cannot be read.
    explicit OutputRecord(std::filesystem::path folder);

    static constexpr const char* file_name = ".fresco-outputs";

    struct NewFile
    {
        std::string name;
        std::string hash;  ///< Hash of the new contents; empty in begin() while unknown.
    };

    /// Why the owner may not replace the file, without its path: "changed since fresco wrote it"; empty: it may, or there is no
    /// file. Reports have no stage, and any pipeline's run may replace them.
    std::string obstacle(const std::string& name, const OutputOwner& owner, FileHashes& hashes) const;
    /// Whether a run was killed while it wrote this file, whose contents were not known before.
    bool is_unfinished(const std::string& name) const;
    /// Notes files that are about to be written. Call before they appear, and `wrote` when all have: a run that is killed between
    /// the two has recorded its own files, and those that they replaced. Throws Error if the record cannot be written.
    void begin(const std::vector<NewFile>& files, const OutputOwner& owner, FileHashes& hashes) { note(files, owner, &hashes); }
    void wrote(const std::vector<NewFile>& files, const OutputOwner& owner) { note(files, owner, nullptr); }
    /// The names that the owner has recorded here.
    std::vector<std::string> names_of(const OutputOwner& owner) const;
    void forget(const std::vector<std::string>& names);

  private:
    void read();
    /// With `hashes`, also what the files replace.
    void note(const std::vector<NewFile>& files, const OutputOwner& owner, FileHashes* hashes);
    void write() const;
    Value identity(const OutputOwner& owner) const;

    std::filesystem::path folder_;
    std::map<std::string, Value> entries_;  ///< Name -> {pipeline, combination, stage, output, hash, before}.
};

/// Throws Error that lists the first of them; does nothing if there are none.
void refuse_obstacles(const std::vector<std::string>& obstacles);

/// Ends the message of an obstacle.
inline constexpr const char* obstacle_advice = "choose another folder with --out, or overwrite it with --replace";

}  // namespace fresco::host

#pragma once

#include "base/file_stamp.h"
#include "pipeline/pipeline.h"
#include "store/store.h"
#include <fresco/files_io.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// \file Copies what stages export to --out, and knows what lies there already.

namespace fresco::host
{

/// The stage's outputs of type "files".
std::vector<std::string> files_outputs(const PipelineStage& stage);

/// Copies what stages made for the user to `--out`, each to its own place there.
class Exporter
{
  public:
    Exporter(const Store& store, std::filesystem::path out, FileHashes& hashes)
        : store_(store), out_(std::move(out)), hashes_(hashes)
    {
    }

    struct File
    {
        std::string stage;
        std::filesystem::path path;
        bool written = false;  ///< False: it was there already, with these contents.
    };

    /// Copies each file of the stage's result that is missing or different, whole or not at all. Throws Error if a file cannot
    /// be written or another stage wrote the same path; throws Damage if the store's copy is not what was written. Asks
    /// `stop` before each file, of which there may be thousands: where it says so, the rest is left to the next run.
    void copy(const PipelineStage& stage, const std::string& object, const std::function<bool()>& stop);
    const std::vector<File>& files() const { return files_; }
    /// How many files of the stage's result `copy` would write.
    std::size_t missing(const PipelineStage& stage, const std::string& object) const;

  private:
    /// Makes the copies, and counts all of `found` among the files. Empties both.
    void place(std::vector<File>& found, std::vector<FileCopy>& copies);
    std::filesystem::path place_of(const PipelineStage& stage, const std::string& name) const;
    bool is_there(const std::filesystem::path& to, const std::filesystem::path& from) const;

    const Store& store_;
    std::filesystem::path out_;
    FileHashes& hashes_;
    std::vector<File> files_;
    OutputOwners owners_;
};

}  // namespace fresco::host

#pragma once

#include "store/store.h"

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

/// \file What the last run of each pipeline file used: the roots of a clean-up, and what `plan` compares with.

namespace fresco::host
{

/// The last result of a stage of a pipeline file: a root for `store gc`, and what `plan` compares with.
struct StageRecord
{
    std::string stage;
    std::string key;
    std::string object;
    Value key_document;
    std::string pipeline{};  ///< As written: the path of its file.
};

/// The path without links; the same path if that cannot be known.
std::filesystem::path resolved(const std::filesystem::path& path);
/// Folder of the records of a pipeline file's stages.
std::filesystem::path pipeline_folder(const Store& store, const std::filesystem::path& pipeline);
/// Record of the pipeline file's stage.
std::optional<StageRecord> read_stage_record(const Store& store, const std::filesystem::path& pipeline, const std::string& stage);
/// Writes the record if it says something new. Its time becomes that of the pipeline's last run in any case.
void write_stage_record(const Store& store, const std::filesystem::path& pipeline, const StageRecord& record);
/// Removes records, and links to logs, of stages that the pipeline file no longer has.
void remove_old_records(const Store& store, const std::filesystem::path& pipeline, const std::set<std::string>& stages);

/// Results that the last runs used.
struct UsedResults
{
    std::set<std::string> objects;
    /// Names of stages whose record is damaged: any result of such a stage may be in use.
    std::set<std::string> stages;
    /// Results of pipelines whose file cannot be seen, because it came from standard input, its disk is not mounted, or it was
    /// moved or removed. Their last runs are younger than `keep_days`.
    std::set<std::string> unseen;
    std::vector<std::filesystem::path> abandoned;  ///< Record folders of those that last ran earlier.
};
UsedResults used_results(const Store& store, double keep_days);
/// Removes such a folder with the records and links in it.
void remove_abandoned(const std::filesystem::path& folder);
/// Days since the file was last written; a missing file counts as written in 1970.
double age_days(const std::filesystem::path& path);

}  // namespace fresco::host

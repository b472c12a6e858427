#pragma once

#include <fresco/artifact.h>
#include <fresco/value.h>

#include <filesystem>
#include <string>
#include <vector>

namespace fresco
{

/// Files for the user: what an export makes. A stage writes each one below its output's folder().path under the relative name
/// that it gets below `--out`, and lists it; the host copies it there, whole or not at all, after the stage and whenever it is
/// missing.
struct Files : Artifact
{
    static constexpr std::string_view artifact_name = "files";
    static constexpr int artifact_version = 1;

    std::vector<std::string> names;     ///< Relative, '/'-separated, without "..".
    std::filesystem::path loaded_from;  ///< Folder where load() found them: each lies at loaded_from / name. Not saved.

    /// Writes `files.json`. Throws Error if a listed file is missing.
    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Files> load(const ArtifactFolder& folder);
    /// Lists every file that there is in and below the folder.
    static std::shared_ptr<Files> from_exchange(const Exchange& from);
};

/// A table: named columns, one Value per cell. On disk: `table.json` {"columns": […], "rows": [[…], …]}.
struct Table : Artifact
{
    static constexpr std::string_view artifact_name = "table";
    static constexpr int artifact_version = 1;

    std::vector<std::string> columns;
    std::vector<std::vector<Value>> rows;  ///< Each of columns.size().

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Table> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
};

}  // namespace fresco

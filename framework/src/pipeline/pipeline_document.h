#pragma once

#include "pipeline/problems.h"
#include "pipeline/yaml_document.h"

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

/// \file A pipeline file as written, with its bases: top-level keys, before vars are put in. load_pipeline and completion
/// read it.

namespace fresco::host
{

/// The key of the components that a pipeline chooses for all its stages. No stage is called so.
inline constexpr std::string_view pipeline_components = "components";

/// A pipeline file with the files it builds on, merged: nothing substituted, no type looked up.
struct PipelineDocument
{
    YamlNode vars;                  ///< A map: name -> value (null: must be given by --set).
    YamlNode matrix;                ///< A map: var -> the values it takes; empty: none.
    YamlNode components;            ///< A map: kind of component -> the one that all stages use; empty: none.
    YamlNode stages;                ///< A map: name -> a map, or an invalid node where that is reported already.
    YamlNode preview;               ///< A map: stage -> its options in a preview; null: none.
    std::set<std::string> dropped;  ///< Stages that were here, and were left out by drop_stages().
    std::vector<PipelineText> texts;
    bool complete = true;  ///< False: a file was not read to its end, so that things may seem to be missing.
};

/// The folder of the pipelines that come with the program.
std::filesystem::path installed_pipelines();

/// Reads `file` (absolute; shown as `shown`) and, through `base: FILE`, the files below it. An entry of the upper file goes
/// before the base's: maps merge, all else replaces; an empty value (`name:`) removes a stage, an option or a named component;
/// where `type` changes, the old type's options are dropped and only the stage's `input` stays. A var without a value in the
/// upper file must be given by `--set`. An axis of the upper file's matrix goes before the base's, an empty one removes it, and a
/// var that the upper file sets is not an axis of the base any more. A file that `texts` has is not read from the disk.
PipelineDocument read_pipeline_document(const std::filesystem::path& file, const std::string& shown,
                                        const std::vector<PipelineText>& texts, ProblemList& problems);

/// Merges the document's preview into its stages, as those of a file above it. A document without one is a problem.
void apply_preview(PipelineDocument& document, const std::string& shown, ProblemList& problems);

/// Leaves out stages that `--without` names. An unknown one is a problem; that another reads one shows when stages are wired.
void drop_stages(PipelineDocument& document, const std::vector<std::string>& names, ProblemList& problems);

}  // namespace fresco::host

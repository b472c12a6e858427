#pragma once

#include "pipeline/pipeline_matrix.h"
#include "pipeline/pipeline_types.h"
#include "pipeline/pipeline_variables.h"

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// \file What --set and previews put in place of values of the file.

namespace fresco::host
{

/// The `--set NAME=VALUE` of a command line: vars, options by "stage.option" and deeper ("texture.losses.style.weight"), and the
/// pipeline's components by "components.kind".
/// A value in [ ], { } or quotes is YAML; any other is taken as it stands.
class Settings
{
  public:
    Settings(const std::vector<std::pair<std::string, std::string>>& sets, const std::filesystem::path& working_directory,
             ProblemList& problems);

    /// Replaces the values of vars and narrows axes. An unknown name, of a stage too, is reported, with the nearest.
    void set_vars(PipelineDocument& document, std::vector<MatrixAxis>& axes);
    /// Replaces options, `input` and `type` in a substituted stage. Inside a component that the file does not give, the default
    /// (and what `auto` stands for) is written out first, so that one of its options can be changed.
    void set_options(const std::string& name, YamlNode& stage, Variables& variables, TypeTable& types,
                     ProblemList& problems) const;
    /// Replaces entries of the substituted `components`, or options in them.
    void set_components(YamlNode& components, Variables& variables, TypeTable& types, ProblemList& problems) const;
    /// The vars that what is set in a stage, or in "components", names.
    std::set<std::string> vars_in(const std::string& stage) const;

  private:
    struct Setting
    {
        std::vector<std::string> path;
        YamlNode value;
    };

    std::vector<Setting> settings_in(const std::string& name, Variables& variables) const;

    std::vector<Setting> settings_;
    ProblemList& problems_;
};

}  // namespace fresco::host

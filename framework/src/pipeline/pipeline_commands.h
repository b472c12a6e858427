#pragma once

#include "pipeline/pipeline_options.h"
#include "pipeline/pipeline_wiring.h"
#include "plugins/command_stage.h"

#include <string>

namespace fresco::host
{

/// \file Checks of what only `type: command` has: words to run, files, and ports that the pipeline declares.

/// The list of words as texts; null after a problem.
Value check_texts(const OptionDeclaration& option, const YamlNode& node, const std::string& user, ProblemList& problems);

/// A map from each path as it is written to the absolute one; reports files that there are not. Null after a problem.
Value check_input_files(const OptionDeclaration& option, const YamlNode& node, const std::string& user, OptionUses& uses,
                        ProblemList& problems);

/// A map {port: {artifact, version, as}}; `as` is empty where the artifact has one form alone. Null after a problem.
Value check_ports(const OptionDeclaration& option, const YamlNode& node, const std::string& user, TypeTable& types,
                  ProblemList& problems);

/// Gives a stage of the type `command`, whose options are checked, a type of its own with the ports that it declares, a picture
/// codec where a port needs one, and reports what cannot run: unknown {names}, outputs that no word tells the program of, files
/// that are used but not declared, programs that there are not.
void complete_command(StageDraft& draft, OptionChecker& checker, TypeTable& types, ProblemList& problems);

/// What the costs of a stage are remembered by: its type, and of a command the program with its first words and files, too.
std::string cost_name(const PipelineStage& stage);

}  // namespace fresco::host

#pragma once

#include "pipeline/pipeline.h"
#include "pipeline/pipeline_types.h"

#include <set>
#include <string>
#include <vector>

/// \file The options of one stage: checked against its declaration, completed, and with what the machine decides (files,
/// devices).

namespace fresco::host
{

/// Files and components that the options of one stage name.
struct OptionUses
{
    std::vector<std::filesystem::path> input_files;
    std::set<const TypeDescription*> components;
    std::vector<PipelineStage::Output> outputs;
};

/// Checks the options of stages and components against their declarations and completes them: defaults filled in, component
/// configurations complete down to their own options, `auto` expanded, paths absolute, in declared order. Reports every problem.
class OptionChecker
{
  public:
    /// `components`: what the pipeline chooses for the kinds of component that stages share; substituted, and checked here.
    OptionChecker(TypeTable& types, YamlNode components, ProblemList& problems);

    /// `config` is the map as written; keys in `taken` are not options. `user` names the owner in problems: "stage 'mesh'
    /// (mesh.decimate)". Options without a value (optional slots, an empty output name) are left out of the result.
    Value complete(const KnownType& type, YamlNode config, const std::vector<std::string>& taken, const std::string& user,
                   OptionUses& uses);
    /// The complete configuration {type: …, options…} of a component of `kind`; null after a problem.
    Value complete_component(std::string_view kind, const YamlNode& config, const std::vector<std::string>& taken,
                             const std::string& user, OptionUses& uses);

  private:
    /// Resolves `node`, the value of a slot that is ByMarks: returns it with a type in place of `auto`, or nothing. `options`:
    /// those that are complete. Reports a path that no component is for, or not the one that is named.
    std::optional<YamlNode> chosen_by_marks(const OptionDeclaration& slot, YamlNode node, const YamlNode& config,
                                            const Value& options, const std::string& user);
    Value complete_slot(const OptionDeclaration& option, const YamlNode& node, const std::string& user, OptionUses& uses);
    /// The complete configuration of a component that the pipeline chooses; null: none.
    Value pipeline_component(const OptionDeclaration& component, const YamlPlace& place, const std::string& user,
                             OptionUses& uses);
    Value check_plain(const OptionDeclaration& option, const YamlNode& node, const std::string& user, OptionUses& uses);

    TypeTable& types_;
    YamlNode components_;
    ProblemList& problems_;
    std::size_t depth_ = 0;
};

/// The node as the option holds it (a path absolute), without looking at the disk, or null after a problem at the place of the
/// part that is wrong.
Value value_of(const OptionDeclaration& option, const YamlNode& node, const std::string& user, ProblemList& problems);

/// The absolute path that an option of the kind input_file, input_folder or input_path holds; reports (as missing input) one that
/// does not exist or cannot be read.
std::filesystem::path check_input_path(const YamlNode& node, OptionKind kind, const std::string& user, ProblemList& problems);
/// Reports (as missing input) a file that is not what its extension says, or has none of `extensions`; nothing where those are
/// empty, and nothing that check_input_path reports.
void check_contents(const YamlNode& node, const std::filesystem::path& file, const std::vector<std::string>& extensions,
                    const std::vector<FileFormat>& formats, const std::string& user, ProblemList& problems);

/// The option that says where stages of the type work (fresco::chooses_device); empty: they have none.
std::string device_option(const TypeDescription& type);

/// Puts "cuda" or "cpu" in place of "auto" in that option: "cuda" where the plugin was built for a GPU and the machine has one,
/// which is asked only then.
void settle_device(const TypeDescription& type, Value& options, bool (*machine_has_gpu)());

/// The types that a stage's slots ByMarks have come to, by option.
std::map<std::string, std::string> types_by_marks(const PipelineStage& stage);

/// Whether the stage works on a GPU, by its settled options.
bool works_on_gpu(const PipelineStage& stage);

}  // namespace fresco::host

#include "pipeline/pipeline_ports.h"
#include <fresco/command_line.h>

#include <algorithm>

namespace fresco::host
{
namespace
{

bool declares_ports(const OptionDeclaration& option)
{
    return option.is_ports() || option.kind == OptionKind::command_line || option.kind == OptionKind::input_files ||
           option.kind == OptionKind::rules;
}

void append_ports(TypeDescription& type, const char* list, const Value& ports)
{
    Value::List all = type.declaration.at(list).as_list();
    for (const auto& [name, port] : ports.as_map())
        all.push_back(
            Value::Map{{"name", name}, {"artifact", port.at("artifact")}, {"version", port.at("version")}, {"help", ""}});
    type.declaration.set(list, std::move(all));
}

void check_commands(const StageDraft& stage, ProblemList& problems)
{
    const auto folder_of = [&](const std::string& option, std::size_t word)
    {
        const YamlNode::Entry* written = stage.config.find(option);
        return written ? written->value.items[word].path_base() : std::filesystem::path();
    };
    for (const CommandLineProblem& problem : check_command_line(stage.type.declaration->options, stage.options, folder_of))
    {
        const YamlNode::Entry* option = stage.config.find(problem.option);
        Position at = option ? option->position() : stage.position;
        if (option && problem.word >= 0)
            at = option->value.items[static_cast<std::size_t>(problem.word)].position();
        problems.add(std::move(at), stage.title() + ": " + problem.text,
                     problem.is_missing ? ProblemKind::missing_input : ProblemKind::invalid);
    }
}

/// An input for each that the rules name, and what is to be checked once it is known whose parts they are for.
void append_named_inputs(StageDraft& stage, TypeDescription& type, const OptionDeclaration& option, ProblemList& problems)
{
    const Value& rules = stage.options.at(option.name);
    const auto at = [&](const std::string& part)
    {
        const YamlNode::Entry* written = stage.config.find(option.name);
        const YamlNode::Entry* rule = written ? written->value.find(part) : nullptr;
        return rule ? rule->position() : stage.position;
    };
    for (const auto& [part, rule] : rules.as_map())
    {
        if (part != other_parts)
            stage.part_uses.push_back({part, option.name, option.rule->parts_of, at(part)});
        if (const std::string& name = rule.at(option.rule->input).as_string(); stage.type.declaration->input(name))
            problems.add(at(part), stage.title() + ": option '" + option.name + "': '" + name +
                                       "' is another input of the stage; expected " + option.rule->word + ", or a " +
                                       option.rule->input + " of another name");
    }
    Value ports = Value::Map{};
    for (const std::string& name : option.inputs_named(rules))
        if (!stage.type.declaration->input(name))
            ports.set(name, Value::Map{{"artifact", option.rule->artifact}, {"version", option.rule->version}});
    append_ports(type, "inputs", ports);
}

}  // namespace

void settle_declared_ports(StageDraft& stage, TypeTable& types, ProblemList& problems)
{
    const std::vector<OptionDeclaration>& options = stage.type.declaration->options;
    if (std::ranges::none_of(options, declares_ports))
        return;
    const auto is_missing = [&](const OptionDeclaration& option)
    { return declares_ports(option) && !stage.options.find(option.name) && (option.required || stage.config.find(option.name)); };
    if (std::ranges::any_of(options, is_missing))
    {
        stage.type = {};
        return;
    }
    check_commands(stage, problems);
    TypeDescription own = *stage.type.description;
    for (const OptionDeclaration& option : options)
        if (option.is_ports())
            append_ports(own, option.kind == OptionKind::input_ports ? "inputs" : "outputs", stage.options.at(option.name));
        else if (option.kind == OptionKind::rules)
            append_named_inputs(stage, own, option, problems);
    stage.own_type = types.adopt(std::move(own));
    stage.type = {stage.own_type.get(), &types.declaration(*stage.own_type)};
}

std::string cost_name(const PipelineStage& stage)
{
    std::string name = stage.type->type;
    std::string files;
    bool runs_program = false;
    // Further words are settings, which differ from one value of an axis to the next.
    constexpr std::size_t telling_words = 3;
    for (const Value& option : stage.type->declaration.at("options").as_list())
    {
        const std::string& kind = option.at("kind").as_string();
        const Value* value = stage.options->find(option.at("name").as_string());
        if (kind == "command_line" && value != nullptr)
        {
            runs_program = true;
            for (std::size_t i = 0; i < std::min(telling_words, value->as_list().size()); ++i)
                name += " " + value->as_list()[i].as_string();
        }
        if (kind == "input_files" && value != nullptr)
            for (const auto& [file, path] : value->as_map())
                files += " " + file;
    }
    return runs_program ? name + files : name;
}

}  // namespace fresco::host

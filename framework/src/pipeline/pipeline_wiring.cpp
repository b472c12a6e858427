#include "pipeline/pipeline_wiring.h"
#include "base/common.h"
#include "base/file_contents.h"
#include <fresco/command.h>
#include <fresco/part_names.h>
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>
#include <ranges>
#include <set>

namespace fresco::host
{

namespace
{

std::string listed(const std::vector<const PortDeclaration*>& ports)
{
    const auto text = [](const PortDeclaration* port) { return port->name + " (" + port->artifact_text() + ")"; };
    return ports.empty() ? "nothing" : join(each(ports, text));
}

bool fits(const PortDeclaration& output, const PortDeclaration& input)
{
    return output.artifact == input.artifact && output.version == input.version;
}

std::vector<std::string> names_of(const std::vector<PortDeclaration>& ports)
{
    return each(ports, &PortDeclaration::name);
}

/// Name of the place where the pipeline declares the stage's inputs, if it does.
std::string declared_by(const TypeDeclaration& type)
{
    const auto option = std::ranges::find(type.options, OptionKind::input_ports, &OptionDeclaration::kind);
    return option == type.options.end() ? "" : ": declare its ports by '" + option->name + "'";
}

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
        Position at = option ? *option : stage.position;
        if (option && problem.word >= 0)
            at = option->value.items[static_cast<std::size_t>(problem.word)];
        problems.add(std::move(at), stage.title() + ": " + problem.text,
                     problem.is_missing ? ProblemKind::missing_input : ProblemKind::invalid);
    }
}

/// An input for each that the rules name, and what is to be checked once it is known whose parts they are for. False where
/// `input` lacks one: then nothing is known of the others either.
bool append_named_inputs(StageDraft& stage, TypeDescription& type, const OptionDeclaration& option, ProblemList& problems)
{
    const YamlNode::Entry* wired = stage.config.find("input");
    std::vector<std::string> words{option.rule->word};
    if (wired)
        std::ranges::copy_if(wired->value.keys(), std::back_inserter(words),
                             [&](const std::string& key) { return !stage.type.declaration->input(key); });
    const std::size_t before = problems.size();
    const Value& rules = stage.options.at(option.name);
    const auto at = [&](const std::string& part)
    {
        const YamlNode::Entry* written = stage.config.find(option.name);
        const YamlNode::Entry* rule = written ? written->value.find(part) : nullptr;
        return rule ? *rule : stage.position;
    };
    for (const auto& [part, rule] : rules.as_map())
    {
        if (part != other_parts)
            stage.part_uses.push_back({part, option.name, option.rule->parts_of, at(part)});
        const std::string& name = rule.at(option.rule->input).as_string();
        const bool is_wired = !wired || !wired->value.is_map() || std::ranges::find(words, name) != words.end();
        if (stage.type.declaration->input(name) || !is_wired)
            problems.add(at(part), stage.title() + ": option '" + option.name + "': 'input' has no " + option.rule->input + " '" +
                                       name + "' for it" + suggestion(name, words));
    }
    Value ports = Value::Map{};
    for (const std::string& name : option.inputs_named(rules))
        if (!stage.type.declaration->input(name))
            ports.set(name, Value::Map{{"artifact", option.rule->artifact}, {"version", option.rule->version}});
    append_ports(type, "inputs", ports);
    return problems.size() == before;
}

using Ports = std::vector<const PortDeclaration*>;

Ports pointers(const std::vector<PortDeclaration>& ports)
{
    return each<const PortDeclaration*>(ports, [](const PortDeclaration& port) { return &port; });
}

class Wiring
{
  public:
    Wiring(std::vector<StageDraft>& stages, const std::set<std::string>& dropped, ProblemList& problems)
        : stages_(stages), dropped_(dropped), readers_(stages.size()), problems_(problems)
    {
        for (std::size_t i = 0; i < stages.size(); ++i)
            index_.emplace(stages[i].name, i);
    }

    void wire_all()
    {
        for (StageDraft& stage : stages_)
            if (const YamlNode::Entry* input = stage.config.find("input"); input && !input->value.is_null())
                note_sources(stage, input->value);
        for (StageDraft& stage : stages_)
            wire(stage);
        for (const StageDraft& stage : stages_)
            check_parts(stage);
    }

  private:
    void report(const StageDraft& stage, const Position& at, const std::string& text) { problems_.add(at, stage.title() + text); }

    /// Reports an input that is something else than `expected`.
    void refuse(const StageDraft& stage, const YamlNode& node, const std::string& expected)
    {
        gave_up_ = true;
        if (node.is_valid())
            report(stage, node, ": " + expected + ", got " + node.summary());
    }

    void wire(StageDraft& stage)
    {
        const YamlNode::Entry* input = stage.config.find("input");
        if (input && input->value.is_null())
            return report(stage, *input, ": 'input' has no value: set a stage's name, or {port: stage, …}");
        gave_up_ = stage.files_failed;
        if (!stage.type)
            return;
        if (input)
            wire_input(stage, input->value, *input);
        for (const PortDeclaration& port : stage.type.declaration->inputs)
            if (!gave_up_ && !port.is_optional && std::ranges::find(stage.wires, port.name, &Wire::port) == stage.wires.end())
                report(stage, input ? *input : stage.position,
                       " needs the input '" + port.name + "' (" + port.artifact_text() + ")" + makers_of(port, stage));
    }

    /// Notes the stages that the words of an input name, for the graph; ports are not known yet.
    void note_sources(StageDraft& stage, const YamlNode& node)
    {
        if (node.is_scalar())
            note_source(stage, node);
        else if (!node.find("file") || (stage.type && stage.type.declaration->input("file")))
            for (const YamlNode::Entry& entry : node.entries)
                if (entry.value.is_scalar())
                    note_source(stage, entry.value);
    }

    void note_source(StageDraft& stage, const YamlNode& node)
    {
        const std::string name = node.text.substr(0, node.text.find('.'));
        const auto found = index_.find(name);
        if (found != index_.end())
        {
            stage.sources.emplace_back(found->second, node);
            readers_[found->second].push_back(index_.at(stage.name));
        }
        else if (dropped_.contains(name))
            problems_.add({"--without " + name, 0, 0},
                          stage.title() + " reads it: leave that out, too (--without " + stage.name + "), or set its input");
        else
            report(
                stage, node,
                ": unknown stage '" + name + "'" + problems_.hint(name, std::views::transform(stages_, &StageDraft::name)) +
                    (node.text.find_first_of("./") != std::string::npos ? "; a file is written {file: " + node.text + "}" : ""));
    }

    void wire_input(StageDraft& stage, const YamlNode& node, const Position& at)
    {
        const TypeDeclaration& type = *stage.type.declaration;
        if (type.inputs.empty())
        {
            if (!(node.is_map() && node.entries.empty()))
                report(stage, at, " takes no input" + declared_by(type));
        }
        else if (node.is_scalar())
            wire_stage(stage, pointers(type.inputs), node);
        else if (!node.is_map())
            refuse(stage, node, "'input' must be a stage's name, {port: stage, …} or {file: PATH}");
        else if (!is_file_input(node, type))
            for (const YamlNode::Entry& entry : node.entries)
                wire_port(stage, entry);
    }

    void wire_port(StageDraft& stage, const YamlNode::Entry& entry)
    {
        const TypeDeclaration& type = *stage.type.declaration;
        const PortDeclaration* port = type.input(entry.key);
        if (!port)
        {
            gave_up_ = true;
            report(stage, entry, " has no input '" + entry.key + "'" + suggestion(entry.key, names_of(type.inputs)));
        }
        else if (entry.value.is_scalar())
            wire_stage(stage, {port}, entry.value);
        else if (!(entry.value.is_map() && entry.value.find("file")))
            refuse(stage, entry.value, "input '" + entry.key + "' must be a stage's name or {file: PATH}");
    }

    /// Wires what one of the source's outputs fits, where that is clear.
    void wire_stage(StageDraft& stage, const Ports& inputs, const YamlNode& node)
    {
        const bool gave_up = std::exchange(gave_up_, true);
        const std::size_t dot = std::min(node.text.find('.'), node.text.size());
        const auto found = index_.find(node.text.substr(0, dot));
        if (found == index_.end() || !stages_[found->second].type)
            return;
        const StageDraft* const from = &stages_[found->second];
        const std::string from_port = node.text.substr(std::min(dot + 1, node.text.size()));
        const TypeDeclaration& type = *from->type.declaration;
        const PortDeclaration* named = type.output(from_port);
        if (!named && !from_port.empty())
            return report(stage, node,
                          ": " + from->title() + " has no output '" + from_port + "'" +
                              suggestion(from_port, names_of(type.outputs)));
        const Ports outputs = named ? Ports{named} : pointers(type.outputs);
        std::vector<std::pair<const PortDeclaration*, const PortDeclaration*>> pairs;
        std::set<const PortDeclaration*> used, wanted;
        for (const PortDeclaration* output : outputs)
            for (const PortDeclaration* input : inputs)
                if (fits(*output, *input))
                {
                    pairs.emplace_back(output, input);
                    used.insert(output);
                    wanted.insert(input);
                }
        if (!pairs.empty() && wanted.size() == pairs.size() && used.size() == pairs.size())
        {
            for (const auto& [output, input] : pairs)
                stage.wires.push_back({input->name, input->artifact, from->name, output->name, {}, {}});
            gave_up_ = gave_up;
            return;
        }
        if (pairs.empty())
            return report(stage, node, ": '" + node.text + "' is " + listed(outputs) + "; expected " + listed(inputs));
        const auto& [output, input] = pairs.front();
        report(stage, node,
               ": '" + node.text + "' is ambiguous: name the ports, such as {" + input->name + ": " + from->name + "." +
                   output->name + "}");
    }

    void check_parts(const StageDraft& stage)
    {
        for (const StageDraft::PartUse& use : stage.part_uses)
        {
            const auto wire = std::ranges::find(stage.wires, use.port, &Wire::port);
            if (wire == stage.wires.end() || wire->from_stage.empty())
                continue;
            const StageDraft& from = stages_[index_.at(wire->from_stage)];
            const std::vector<std::string> parts = names_for_rules(from.type.declaration->output(wire->from_port)->parts);
            if (!parts.empty() && std::ranges::find(parts, use.part) == parts.end())
                report(stage, use.position,
                       ": option '" + use.option + "': " + from.title() + " makes no '" + use.part + "'" +
                           suggestion(use.part, parts));
        }
    }

    std::string makers_of(const PortDeclaration& port, const StageDraft& user) const
    {
        if (!problems_.takes_hints())
            return {};
        std::vector<std::string> makers;
        const std::vector<bool> closes_cycle = later_than(user);
        for (std::size_t i = 0; i < stages_.size(); ++i)
            if (stages_[i].type && !closes_cycle[i])
                for (const PortDeclaration& output : stages_[i].type.declaration->outputs)
                    if (fits(output, port) && makers.size() < 6)
                        makers.push_back(stages_[i].name + "." + output.name);
        return makers.empty() ? "; no other stage of this pipeline makes " + port.artifact_text() + " before it"
                              : "; it is made by " + join(makers);
    }

    /// Per stage, whether it is `first` or reads of it, also by others.
    std::vector<bool> later_than(const StageDraft& first) const
    {
        std::vector<bool> later(stages_.size());
        std::vector<std::size_t> open{index_.at(first.name)};
        while (!open.empty())
        {
            const std::size_t at = open.back();
            open.pop_back();
            if (!later[at])
                open.insert(open.end(), readers_[at].begin(), readers_[at].end());
            later[at] = true;
        }
        return later;
    }

    std::vector<StageDraft>& stages_;
    const std::set<std::string>& dropped_;
    std::map<std::string, std::size_t, std::less<>> index_;
    std::vector<std::vector<std::size_t>> readers_;  ///< Per stage, those whose inputs name it.
    ProblemList& problems_;
    bool gave_up_ = false;  ///< An input of the current stage could not be resolved: missing ones are not reported.
};

/// Wires a file of a stage's input through a reader. False after a problem.
bool wire_file(StageDraft& stage, const Ports& inputs, const YamlNode& node, TypeTable& types, OptionChecker& options,
               ProblemList& problems)
{
    const YamlNode& file = node.find("file")->value;
    const std::string user = stage.title() + ": input" + (inputs.size() == 1 ? " '" + inputs[0]->name + "'" : "");
    if (file.is_null())
        problems.add(file, user + ": 'file' has no value: set it to the path of an existing file");
    const Value path =
        file.is_null() ? Value() : value_of({.name = "file", .kind = OptionKind::input_file}, file, user, problems);
    if (path.is_null())
        return false;
    // An empty text says: not given. The port is then missing, or an optional one left out.
    if (path.as_string().empty())
        return true;
    const std::filesystem::path absolute = check_input_path(file, OptionKind::input_file, user, problems);
    const YamlNode::Entry* wanted = node.find("type");
    const auto type = wanted ? type_named_by(node, user, &problems) : std::nullopt;
    if (wanted && (!type || !types.require(*type, "reader", user, wanted->value, problems)))
        return false;
    const std::string extension = lower_extension(absolute);
    std::vector<std::pair<KnownType, const PortDeclaration*>> readers;
    std::set<std::string> extensions;
    std::vector<std::string> ways;
    std::string kind;
    for (const TypeDescription* description : types.catalog().types("reader"))
        for (const PortDeclaration* input : inputs)
            if (const KnownType reader = types.find(description->type, "reader");
                reader && (!type || *type == description->type) && reader.declaration->artifact == input->artifact)
            {
                const std::vector<std::string>& known = reader.declaration->extensions;
                extensions.insert(known.begin(), known.end());
                kind = kind.empty() ? known_kind(absolute, reader.declaration->formats) : kind;
                if (std::ranges::find(known, extension) == known.end())
                    continue;
                readers.emplace_back(reader, input);
                ways.push_back((inputs.size() == 1 ? "type: " : input->name + " by ") + description->type);
            }
    if (readers.empty() && !kind.empty())
        problems.add(file, user + ": '" + absolute.filename().string() + "' is " + kind, ProblemKind::missing_input);
    else if (readers.empty())
        problems.add(file, stage.title() + ": " + (type ? "'" + *type + "' makes no " : "no reader makes ") +
                               join(each(inputs, &PortDeclaration::artifact)) + " from '" + absolute.filename().string() + "'" +
                               (extensions.empty() ? "" : "; expected " + join({extensions.begin(), extensions.end()}, " or ")));
    else if (readers.size() > 1)
        problems.add(node, user + ": the file can be read in several ways; choose one: " + join(ways, " or "));
    if (readers.size() != 1)
        return false;
    const auto& [reader, port] = readers.front();
    check_contents(file, absolute, reader.declaration->extensions, reader.declaration->formats, user, problems);
    YamlNode config = node;
    if (!wanted)
        config.set("type", yaml_from_value(reader.description->type, node));
    Value completed =
        options.complete_component("reader", config, {"file"}, stage.title() + ": input '" + port->name + "'", stage.uses);
    stage.uses.input_files.push_back(absolute);
    stage.wires.push_back({port->name, port->artifact, {}, {}, absolute, std::move(completed)});
    return true;
}

}  // namespace

bool is_file_input(const YamlNode& input, const TypeDeclaration& type)
{
    return input.is_map() && input.find("file") && !type.input("file");
}

std::string StageDraft::title() const
{
    return "stage '" + name + "'" + (type ? " (" + type.description->type + ")" : "");
}

void wire_stages(std::vector<StageDraft>& stages, const std::set<std::string>& dropped, ProblemList& problems)
{
    Wiring(stages, dropped, problems).wire_all();
}

StageGraph check_graph(const std::vector<StageDraft>& stages, ProblemList& problems)
{
    constexpr std::size_t shown = 8;
    StageGraph graph(stages.size());
    for (std::size_t i = 0; i < stages.size(); ++i)
        for (const auto& [source, position] : stages[i].sources)
            graph.add_edge(source, i);
    for (const std::vector<std::size_t>& cycle : graph.cycles())
    {
        const StageDraft& first = stages[cycle.front()];
        std::string text = "cycle: ";
        for (std::size_t i = 0; i < cycle.size() && i < shown; ++i)
            text += stages[cycle[i]].name + " → ";
        if (cycle.size() > shown)
            text += fmt::format("… ({} stages) → ", cycle.size());
        const auto closing = std::ranges::find_if(first.sources, [&](const auto& s) { return s.first == cycle.back(); });
        problems.add(closing == first.sources.end() ? first.position : closing->second, text + first.name);
    }
    return graph;
}

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
        else if (option.kind == OptionKind::rules && !append_named_inputs(stage, own, option, problems))
        {
            stage.type = {};
            return;
        }
    stage.own_type = types.adopt(std::move(own));
    stage.type = {stage.own_type.get(), &types.declaration(*stage.own_type)};
}

std::string program_name(const PipelineStage& stage)
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

void wire_files(StageDraft& stage, TypeTable& types, OptionChecker& options, ProblemList& problems)
{
    const YamlNode::Entry* input = stage.type ? stage.config.find("input") : nullptr;
    if (!input || !input->value.is_map())
        return;
    const TypeDeclaration& type = *stage.type.declaration;
    if (is_file_input(input->value, type))
        stage.files_failed =
            !type.inputs.empty() && !wire_file(stage, pointers(type.inputs), input->value, types, options, problems);
    else
        for (const YamlNode::Entry& entry : input->value.entries)
            if (const PortDeclaration* port = type.input(entry.key); port && entry.value.is_map() && entry.value.find("file"))
                stage.files_failed = !wire_file(stage, {port}, entry.value, types, options, problems) || stage.files_failed;
}

}  // namespace fresco::host

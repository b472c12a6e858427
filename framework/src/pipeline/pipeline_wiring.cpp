#include "pipeline/pipeline_wiring.h"
#include "base/common.h"
#include <fresco/command.h>
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace fresco::host
{

namespace
{

std::string listed(const std::vector<const PortDeclaration*>& ports)
{
    std::vector<std::string> texts;
    for (const PortDeclaration* port : ports)
        texts.push_back(port->name + " (" + port->artifact_text() + ")");
    return texts.empty() ? "nothing" : join(texts);
}

bool fits(const PortDeclaration& output, const PortDeclaration& input)
{
    return output.artifact == input.artifact && output.version == input.version;
}

std::vector<std::string> names_of(const std::vector<PortDeclaration>& ports)
{
    return each(ports, &PortDeclaration::name);
}

/// Where the stage's inputs would be declared, if the pipeline does that.
std::string declared_by(const TypeDeclaration& type)
{
    const auto option = std::ranges::find(type.options, OptionKind::input_ports, &OptionDeclaration::kind);
    return option == type.options.end() ? "" : ": declare its ports by '" + option->name + "'";
}

bool looks_like_path(const std::string& text)
{
    return text.find('/') != std::string::npos || std::filesystem::path(text).has_extension();
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

std::vector<const PortDeclaration*> pointers(const std::vector<PortDeclaration>& ports)
{
    return each<const PortDeclaration*>(ports, [&](const PortDeclaration& port) { return &port; });
}

bool is_file_input(const YamlNode& input, const TypeDeclaration& type)
{
    return input.is_map() && input.find("file") && !type.input("file");
}

std::string StageDraft::title() const
{
    return "stage '" + name + "'" + (type ? " (" + type.description->type + ")" : "");
}

Wiring::Wiring(std::vector<StageDraft>& stages, ProblemList& problems) : stages_(stages), problems_(problems)
{
    for (std::size_t i = 0; i < stages.size(); ++i)
        index_.emplace(stages[i].name, i);
}

void Wiring::wire_all()
{
    for (StageDraft& stage : stages_)
        wire(stage);
    for (const StageDraft& stage : stages_)
        check_parts(stage);
    // Only now it is known which stages would close a cycle.
    for (const auto& [stage, at] : unwired_)
        report_unwired(*stage, at);
}

void Wiring::wire(StageDraft& stage)
{
    const YamlNode::Entry* input = stage.config.find("input");
    if (input && !stage.type)
        follow_blindly(stage, input->value);
    if (!stage.type)
        return;
    gave_up_ = stage.files_failed;
    const TypeDeclaration& type = *stage.type.declaration;
    if (input && input->value.is_null())
        problems_.add(input->position(), stage.title() + ": 'input' has no value: set a stage's name, or {port: stage, …}");
    else if (input && type.inputs.empty())
    {
        if (!(input->value.is_map() && input->value.entries.empty()))
            problems_.add(input->position(), stage.title() + " takes no input" + declared_by(type));
        follow_blindly(stage, input->value);
    }
    else if (input)
        wire_one(stage, input->value);
    if (!gave_up_ && !(input && input->value.is_null()))
        unwired_.emplace_back(&stage, input ? input->position() : stage.position);
}

void Wiring::wire_one(StageDraft& stage, const YamlNode& node)
{
    const TypeDeclaration& type = *stage.type.declaration;
    if (node.is_scalar())
        wire_stage(stage, pointers(type.inputs), node);
    else if (node.is_map())
    {
        if (!is_file_input(node, type))
            wire_ports(stage, node);
    }
    else
    {
        gave_up_ = true;
        if (node.is_valid())
            problems_.add(node.position(), stage.title() +
                                               ": 'input' must be a stage's name, {port: stage, …} or {file: PATH}, got " +
                                               node.summary());
    }
}

void Wiring::wire_ports(StageDraft& stage, const YamlNode& map)
{
    const TypeDeclaration& type = *stage.type.declaration;
    for (const YamlNode::Entry& entry : map.entries)
    {
        const PortDeclaration* port = type.input(entry.key);
        if (!port)
        {
            problems_.add(entry.position(),
                          stage.title() + " has no input '" + entry.key + "'" + suggestion(entry.key, names_of(type.inputs)));
            follow_blindly(stage, entry.value);
        }
        else if (entry.value.is_scalar())
            wire_stage(stage, {port}, entry.value);
        else if (!(entry.value.is_map() && entry.value.find("file")))
        {
            gave_up_ = true;
            if (entry.value.is_valid())
                problems_.add(entry.value.position(), stage.title() + ": input '" + entry.key +
                                                          "' must be a stage's name or {file: PATH}, got " +
                                                          entry.value.summary());
        }
    }
}

bool Wiring::find_source(StageDraft& stage, const YamlNode& node, Source& source)
{
    const std::size_t dot = node.text.find('.');
    const std::string name = node.text.substr(0, dot);
    const auto found = index_.find(name);
    if (found == index_.end())
    {
        std::vector<std::string> names;
        if (problems_.takes_hints())
            for (const StageDraft& other : stages_)
                names.push_back(other.name);
        const std::string meant = suggestion(name, names);
        problems_.add(node.position(), stage.title() + ": unknown stage '" + name + "'" + meant +
                                           (looks_like_path(node.text) ? "; a file is written {file: " + node.text + "}" : ""));
        gave_up_ = true;
        return false;
    }
    source.stage = found->second;
    source.port = dot == std::string::npos ? "" : node.text.substr(dot + 1);
    stage.sources.emplace_back(source.stage, node.position());
    return true;
}

Wiring::Ports Wiring::outputs_of(const Source& source, const YamlNode& node, const StageDraft& user)
{
    const StageDraft& from = stages_[source.stage];
    const TypeDeclaration& type = *from.type.declaration;
    if (source.port.empty())
        return pointers(type.outputs);
    if (const PortDeclaration* port = type.output(source.port))
        return {port};
    problems_.add(node.position(), user.title() + ": " + from.title() + " has no output '" + source.port + "'" +
                                       suggestion(source.port, names_of(type.outputs)));
    gave_up_ = true;
    return {};
}

void Wiring::wire_stage(StageDraft& stage, const Ports& inputs, const YamlNode& node)
{
    Source source;
    if (!find_source(stage, node, source))
        return;
    const StageDraft& from = stages_[source.stage];
    if (!from.type)
    {
        gave_up_ = true;
        return;
    }
    const Ports outputs = outputs_of(source, node, stage);
    if (outputs.empty() && gave_up_)
        return;
    std::vector<std::pair<const PortDeclaration*, const PortDeclaration*>> pairs;
    for (const PortDeclaration* output : outputs)
        for (const PortDeclaration* input : inputs)
            if (fits(*output, *input))
                pairs.emplace_back(output, input);
    std::set<const PortDeclaration*> used, wanted;
    for (const auto& [output, input] : pairs)
    {
        used.insert(output);
        wanted.insert(input);
    }
    const bool all = wanted.size() == pairs.size();
    if (!pairs.empty() && all && used.size() == pairs.size())
    {
        for (const auto& [output, input] : pairs)
            stage.wires.push_back({input->name, input->artifact, from.name, output->name, {}, {}});
        return;
    }
    gave_up_ = true;
    const std::string makes = source.port.empty()
                                  ? from.title() + " makes " + listed(outputs)
                                  : "output '" + source.port + "' of " + from.title() + " is " + outputs[0]->artifact_text();
    if (pairs.empty())
    {
        const std::string takes = inputs.size() == 1 ? ": input '" + inputs[0]->name + "' takes " + inputs[0]->artifact_text()
                                                     : " takes " + listed(inputs);
        problems_.add(node.position(), stage.title() + takes + ", but " + makes);
        return;
    }
    // Several inputs that fit one output are all meant to be named; else one of several ways is.
    std::vector<std::string> ways;
    for (const auto& [output, input] : pairs)
        ways.push_back((all ? "" : "{") + input->name + ": " + from.name + "." + output->name + (all ? "" : "}"));
    const std::string named = all ? "{" + join(ways, ", ") + "}" : join(ways, " or ");
    problems_.add(node.position(), stage.title() + ": '" + node.text + "' is ambiguous: name the port" +
                                       (inputs.size() == 1 ? ": " : "s: ") + named);
}

void Wiring::check_parts(const StageDraft& stage)
{
    for (const StageDraft::PartUse& use : stage.part_uses)
    {
        const auto wire = std::ranges::find(stage.wires, use.port, &Wire::port);
        if (wire == stage.wires.end() || wire->from_stage.empty())
            continue;
        const StageDraft& from = stages_[index_.at(wire->from_stage)];
        const std::vector<std::string>& parts = from.type.declaration->output(wire->from_port)->parts;
        if (!parts.empty() && std::ranges::find(parts, use.part) == parts.end())
            problems_.add(use.position, stage.title() + ": option '" + use.option + "': " + from.title() + " makes no '" +
                                            use.part + "'" + suggestion(use.part, parts));
    }
}

bool Wiring::needs(const StageDraft& stage, const StageDraft& wanted) const
{
    std::vector<const StageDraft*> open{&stage};
    std::set<const StageDraft*> seen{&stage};
    while (!open.empty())
    {
        const StageDraft& next = *open.back();
        open.pop_back();
        if (&next == &wanted)
            return true;
        for (const auto& [source, position] : next.sources)
            if (seen.insert(&stages_[source]).second)
                open.push_back(&stages_[source]);
    }
    return false;
}

std::string Wiring::makers_of(const PortDeclaration& port, const StageDraft& user) const
{
    if (!problems_.takes_hints())
        return {};
    std::vector<std::string> makers;
    for (const StageDraft& stage : stages_)
        if (stage.type && !needs(stage, user))
            for (const PortDeclaration& output : stage.type.declaration->outputs)
                if (fits(output, port) && makers.size() < 6)
                    makers.push_back(stage.name + "." + output.name);
    return makers.empty() ? "; no stage of this pipeline makes " + port.artifact_text() : "; it is made by " + join(makers);
}

void Wiring::report_unwired(const StageDraft& stage, const Position& at)
{
    for (const PortDeclaration& port : stage.type.declaration->inputs)
    {
        const bool wired = std::ranges::any_of(stage.wires, [&](const Wire& wire) { return wire.port == port.name; });
        if (!wired && !port.is_optional)
            problems_.add(at, stage.title() + " needs the input '" + port.name + "' (" + port.artifact_text() + ")" +
                                  makers_of(port, stage));
    }
}

void Wiring::follow_blindly(StageDraft& stage, const YamlNode& node)
{
    if (node.is_scalar())
    {
        Source source;
        find_source(stage, node, source);
    }
    else if (node.is_map() && !node.find("file"))
        for (const YamlNode::Entry& entry : node.entries)
            if (entry.value.is_scalar())
                follow_blindly(stage, entry.value);
    gave_up_ = true;
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

void FileInputs::wire(StageDraft& stage)
{
    const YamlNode::Entry* input = stage.type ? stage.config.find("input") : nullptr;
    if (!input || !input->value.is_map())
        return;
    const TypeDeclaration& type = *stage.type.declaration;
    if (type.inputs.empty())
        return;
    if (is_file_input(input->value, type))
    {
        stage.files_failed = !wire_file(stage, pointers(type.inputs), input->value);
        return;
    }
    for (const YamlNode::Entry& entry : input->value.entries)
        if (const PortDeclaration* port = type.input(entry.key); port && entry.value.is_map() && entry.value.find("file"))
            stage.files_failed = !wire_file(stage, {port}, entry.value) || stage.files_failed;
}

std::vector<std::pair<KnownType, const PortDeclaration*>>
FileInputs::readers_for(const Ports& inputs, const std::string& extension, const YamlNode& node, const StageDraft& stage)
{
    std::vector<std::pair<KnownType, const PortDeclaration*>> fitting;
    std::vector<std::string> extensions;
    const YamlNode::Entry* wanted = node.find("type");
    for (const TypeDescription* description : types_.catalog().types("reader"))
    {
        const KnownType reader = types_.find(description->type, "reader");
        if (!reader || (wanted && wanted->value.text != description->type))
            continue;
        for (const PortDeclaration* input : inputs)
        {
            if (reader.declaration->artifact != input->artifact)
                continue;
            const std::vector<std::string>& known = reader.declaration->extensions;
            extensions.insert(extensions.end(), known.begin(), known.end());
            if (std::find(known.begin(), known.end(), extension) != known.end())
                fitting.emplace_back(reader, input);
        }
    }
    if (!fitting.empty())
        return fitting;
    std::sort(extensions.begin(), extensions.end());
    extensions.erase(std::unique(extensions.begin(), extensions.end()), extensions.end());
    const std::vector<std::string> artifacts = each(inputs, &PortDeclaration::artifact);
    const std::string what = wanted ? "'" + wanted->value.text + "' makes no " : "no reader makes ";
    problems_.add(node.find("file")->value.position(),
                  stage.title() + ": " + what + join(artifacts) + " from " +
                      (extension.empty() ? "a file without an extension" : "'" + extension + "' files") +
                      (extensions.empty() ? "" : " (there are: " + join(extensions, ", ") + ")"));
    return {};
}

bool FileInputs::wire_file(StageDraft& stage, const Ports& inputs, const YamlNode& node)
{
    const YamlNode& file = node.find("file")->value;
    const std::string user = stage.title() + ": input" + (inputs.size() == 1 ? " '" + inputs[0]->name + "'" : "");
    const OptionDeclaration declared{.name = "file", .kind = OptionKind::input_file};
    const Value path = file.is_null() ? Value() : value_of(declared, file, user, problems_);
    if (file.is_null())
        problems_.add(file.position(), user + ": 'file' has no value: set it to " + declared.accepted());
    if (path.is_null())
        return false;
    // An empty text says: not given. The port is then missing, or an optional one left out.
    if (path.as_string().empty())
        return true;
    const std::filesystem::path absolute = check_input_path(file, false, user, problems_);
    if (const YamlNode::Entry* wanted = node.find("type"))
    {
        const auto type = type_named_by(node, user, &problems_);
        if (!type || !types_.require(*type, "reader", user, wanted->value.position(), problems_))
            return false;
    }
    const auto readers = readers_for(inputs, lower_extension(absolute), node, stage);
    if (readers.empty())
        return false;
    if (readers.size() > 1)
    {
        std::vector<std::string> ways;
        for (const auto& [reader, port] : readers)
            ways.push_back(inputs.size() == 1 ? "type: " + reader.description->type
                                              : port->name + " by " + reader.description->type);
        problems_.add(node.position(), user + ": the file can be read in several ways; choose one: " + join(ways, " or "));
        return false;
    }
    const auto& [reader, port] = readers.front();
    check_contents(file, absolute, reader.declaration->extensions, reader.declaration->formats, types_, user, problems_);
    YamlNode config = node;
    if (!config.find("type"))
        config.set("type", yaml_from_value(reader.description->type, node));
    Wire wire{port->name, port->artifact, {}, {}, absolute, {}};
    wire.reader =
        options_.complete_component("reader", config, {"file"}, stage.title() + ": input '" + port->name + "'", stage.uses);
    stage.uses.input_files.push_back(absolute);
    stage.wires.push_back(std::move(wire));
    return true;
}

}  // namespace fresco::host

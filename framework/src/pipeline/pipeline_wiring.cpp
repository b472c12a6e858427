#include "pipeline/pipeline_wiring.h"
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
    std::vector<std::string> names;
    for (const PortDeclaration& port : ports)
        names.push_back(port.name);
    return names;
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
}  // namespace

std::vector<const PortDeclaration*> pointers(const std::vector<PortDeclaration>& ports)
{
    std::vector<const PortDeclaration*> result;
    for (const PortDeclaration& port : ports)
        result.push_back(&port);
    return result;
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
    const auto place = [&](const Wire& wire) { return type.input(wire.port) - type.inputs.data(); };
    std::sort(stage.wires.begin(), stage.wires.end(), [&](const Wire& a, const Wire& b) { return place(a) < place(b); });
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
        const bool wired =
            std::any_of(stage.wires.begin(), stage.wires.end(), [&](const Wire& wire) { return wire.port == port.name; });
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
        const auto closing =
            std::find_if(first.sources.begin(), first.sources.end(), [&](const auto& s) { return s.first == cycle.back(); });
        problems.add(closing == first.sources.end() ? first.position : closing->second, text + first.name);
    }
    return graph;
}

}  // namespace fresco::host

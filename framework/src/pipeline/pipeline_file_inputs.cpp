#include "pipeline/pipeline_file_inputs.h"
#include <fresco/wording.h>

#include <algorithm>

namespace fresco::host
{

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
    for (const TypeDescription* description : types_.of_kind("reader"))
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
    std::vector<std::string> artifacts;
    for (const PortDeclaration* input : inputs)
        artifacts.push_back(input->artifact);
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
    std::string extension = absolute.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    const auto readers = readers_for(inputs, extension, node, stage);
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

#include "plugins/declaration.h"
#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>

namespace fresco::host
{
namespace
{
std::string text_at(const Value& map, std::string_view key)
{
    const Value* entry = map.find(key);
    return entry ? entry->as_string() : std::string();
}

std::vector<std::string> texts_at(const Value& map, std::string_view key)
{
    std::vector<std::string> texts;
    if (const Value* list = map.find(key))
        for (const Value& entry : list->as_list())
            texts.push_back(entry.as_string());
    return texts;
}

bool flag_at(const Value& map, std::string_view key, bool otherwise)
{
    const Value* entry = map.find(key);
    return entry ? entry->as_bool() : otherwise;
}

std::vector<PortDeclaration> read_ports(const Value& declaration, std::string_view key)
{
    std::vector<PortDeclaration> ports;
    if (const Value* list = declaration.find(key))
        for (const Value& description : list->as_list())
        {
            const Value* version = description.find("version");
            ports.push_back({description.at("name").as_string(), description.at("artifact").as_string(),
                             version ? static_cast<int>(version->as_int()) : 1, flag_at(description, "optional", false),
                             text_at(description, "help"), texts_at(description, "parts")});
        }
    return ports;
}

template <class T>
const T* by_name(const std::vector<T>& list, std::string_view name)
{
    const auto found = std::find_if(list.begin(), list.end(), [&](const T& entry) { return entry.name == name; });
    return found == list.end() ? nullptr : &*found;
}
}  // namespace

std::string PortDeclaration::artifact_text() const
{
    return version == 1 ? artifact : artifact + " (version " + std::to_string(version) + ")";
}

const OptionDeclaration* TypeDeclaration::option(std::string_view name) const
{
    return by_name(options, name);
}

const PortDeclaration* TypeDeclaration::input(std::string_view name) const
{
    return by_name(inputs, name);
}

const PortDeclaration* TypeDeclaration::output(std::string_view name) const
{
    return by_name(outputs, name);
}

std::vector<std::string> TypeDeclaration::option_names() const
{
    std::vector<std::string> names;
    for (const OptionDeclaration& option : options)
        names.push_back(option.name);
    return names;
}

TypeDeclaration read_declaration(const TypeDescription& type)
{
    try
    {
        TypeDeclaration result;
        if (const Value* options = type.declaration.find("options"))
            for (const Value& description : options->as_list())
                result.options.push_back(OptionDeclaration::from(description));
        result.inputs = read_ports(type.declaration, "inputs");
        result.outputs = read_ports(type.declaration, "outputs");
        result.artifact = text_at(type.declaration, "artifact");
        result.extensions = texts_at(type.declaration, "extensions");
        if (const Value* formats = type.declaration.find("formats"))
            for (const Value& format : formats->as_list())
                result.formats.push_back(FileFormat::from(format));
        return result;
    }
    catch (const Error& error)
    {
        throw Error(type.library.string() + ": the description of '" + type.type + "' is not as expected: " + error.what());
    }
}

}  // namespace fresco::host

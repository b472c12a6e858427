#include "plugins/catalog.h"
#include "base/common.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <fmt/ranges.h>

namespace fresco::host
{

const std::string& PluginBytes::hash() const
{
    if (hash_.empty())
        hash_ = content_hash(fmt::format("{}", fmt::join(each(files_, file_hash), "/")));
    return hash_;
}

void Catalog::add(TypeDescription description)
{
    std::vector<TypeDescription>& same = types_[description.type];
    if (!same.empty() && same.front().place < description.place)
        shadowed_.push_back({description.type, description.library, same.front().library});
    else
        same.push_back(std::move(description));
}

const UnbuiltPlugin* Catalog::find_unbuilt(std::string_view type) const
{
    const auto found = std::ranges::find(unbuilt_, type, &UnbuiltPlugin::type);
    return found != unbuilt_.end() ? &*found : nullptr;
}

const TypeDescription* Catalog::find(std::string_view type) const
{
    const auto found = types_.find(type);
    return found != types_.end() && found->second.size() == 1 ? &found->second.front() : nullptr;
}

std::vector<const TypeDescription*> Catalog::types(std::string_view kind) const
{
    std::vector<const TypeDescription*> result;
    for (const auto& [name, descriptions] : types_)
        if (descriptions.size() == 1 && (kind.empty() || descriptions.front().kind == kind))
            result.push_back(&descriptions.front());
    return result;
}

std::vector<std::string> Catalog::ambiguous() const
{
    std::vector<std::string> names;
    for (const auto& [name, descriptions] : types_)
        if (descriptions.size() > 1)
            names.push_back(name);
    return names;
}

std::vector<std::string> Catalog::libraries_of(std::string_view type) const
{
    const auto found = types_.find(type);
    return found == types_.end() ? std::vector<std::string>() : each<std::string>(found->second, &TypeDescription::library);
}

namespace
{

std::string text_at(const Value& map, std::string_view key)
{
    const Value* entry = map.find(key);
    return entry ? entry->as_string() : std::string();
}

/// The entries of a list, each read; none where it is missing.
template <class Read>
auto list_at(const Value& map, std::string_view key, const Read& read)
{
    const Value* list = map.find(key);
    return each(list ? list->as_list() : Value::List(), read);
}

PortDeclaration read_port(const Value& description)
{
    const Value* version = description.find("version");
    const Value* optional = description.find("optional");
    return {description.at("name").as_string(),
            description.at("artifact").as_string(),
            version ? static_cast<int>(version->as_int()) : 1,
            optional && optional->as_bool(),
            text_at(description, "help"),
            list_at(description, "parts", &Value::as_string)};
}

template <class T>
const T* by_name(const std::vector<T>& list, std::string_view name)
{
    const auto found = std::ranges::find(list, name, &T::name);
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
    return each(options, &OptionDeclaration::name);
}

TypeDeclaration read_declaration(const TypeDescription& type)
{
    try
    {
        TypeDeclaration result;
        result.options = list_at(type.declaration, "options", OptionDeclaration::from);
        result.components = list_at(type.declaration, "components", OptionDeclaration::from);
        result.inputs = list_at(type.declaration, "inputs", read_port);
        result.outputs = list_at(type.declaration, "outputs", read_port);
        result.artifact = text_at(type.declaration, "artifact");
        result.extensions = list_at(type.declaration, "extensions", &Value::as_string);
        result.formats = list_at(type.declaration, "formats", FileFormat::from);
        if (const Value* marks = type.declaration.find("marks"))
            result.marks = Marks::from(*marks);
        return result;
    }
    catch (const Error& error)
    {
        throw Error(type.library.string() + ": the description of '" + type.type + "' is not as expected: " + error.what());
    }
}

}  // namespace fresco::host

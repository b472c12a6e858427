#include <fresco/error.h>
#include <fresco/host/declaration.h>
#include <fresco/host/suggest.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace fresco::host
{
namespace
{
constexpr std::array<std::pair<std::string_view, OptionKind>, 14> option_kinds{{{"bool", OptionKind::boolean},
                                                                                {"int", OptionKind::integer},
                                                                                {"number", OptionKind::number},
                                                                                {"text", OptionKind::text},
                                                                                {"ints", OptionKind::integers},
                                                                                {"numbers", OptionKind::numbers},
                                                                                {"input_file", OptionKind::input_file},
                                                                                {"input_folder", OptionKind::input_folder},
                                                                                {"output_name", OptionKind::output_name},
                                                                                {"component", OptionKind::component},
                                                                                {"components", OptionKind::components},
                                                                                {"texts", OptionKind::texts},
                                                                                {"input_files", OptionKind::input_files},
                                                                                {"ports", OptionKind::ports}}};

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

std::optional<double> number_at(const Value& map, std::string_view key)
{
    const Value* entry = map.find(key);
    return entry ? std::optional(entry->as_double()) : std::nullopt;
}

bool flag_at(const Value& map, std::string_view key, bool otherwise)
{
    const Value* entry = map.find(key);
    return entry ? entry->as_bool() : otherwise;
}

OptionDeclaration read_option(const Value& description)
{
    OptionDeclaration option;
    option.name = description.at("name").as_string();
    const std::string& kind = description.at("kind").as_string();
    const auto known =
        std::find_if(option_kinds.begin(), option_kinds.end(), [&](const auto& entry) { return entry.first == kind; });
    if (known == option_kinds.end())
        throw Error("option '" + option.name + "' is of the unknown kind '" + kind + "'");
    option.kind = known->second;
    if (const Value* value = description.find("default"))
        option.default_value = *value;
    option.required = flag_at(description, "required", false);
    option.min = number_at(description, "min");
    option.max = number_at(description, "max");
    option.choices = texts_at(description, "choices");
    option.unit = text_at(description, "unit");
    option.in_key = flag_at(description, "in_key", true);
    option.component_kind = text_at(description, "component_kind");
    option.optional =
        option.kind == OptionKind::component && (option.default_value.is_null() || flag_at(description, "optional", false));
    option.help = text_at(description, "help");
    if (const Value* rule = description.find("auto"))
        option.auto_rule = AutoRule{rule->at("option").as_string(), rule->at("if_empty"), rule->at("if_set")};
    return option;
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
                             text_at(description, "help")});
        }
    return ports;
}

template <class T>
const T* by_name(const std::vector<T>& list, std::string_view name)
{
    const auto found = std::find_if(list.begin(), list.end(), [&](const T& entry) { return entry.name == name; });
    return found == list.end() ? nullptr : &*found;
}

std::string range_text(const OptionDeclaration& option)
{
    if (option.min && option.max)
        return " from " + number_text(*option.min) + " to " + number_text(*option.max);
    if (option.min)
        return " of at least " + number_text(*option.min);
    return option.max ? " of at most " + number_text(*option.max) : "";
}
}  // namespace

std::string number_text(double number)
{
    std::array<char, 64> buffer{};
    const bool whole = std::abs(number) < 1e15 && number == std::floor(number);
    const auto end = whole ? std::to_chars(buffer.data(), buffer.data() + buffer.size(), static_cast<long long>(number)).ptr
                           : std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
    return std::string(buffer.data(), end);
}

std::string OptionDeclaration::accepted() const
{
    switch (kind)
    {
    case OptionKind::boolean:
        return "true or false";
    case OptionKind::integer:
        return "an integer" + range_text(*this);
    case OptionKind::number:
        return "a number" + range_text(*this);
    case OptionKind::text:
        return choices.empty() ? "text" : "one of " + join(choices, ", ");
    case OptionKind::integers:
        return "a list, each entry an integer" + range_text(*this);
    case OptionKind::numbers:
        return "a list, each entry a number" + range_text(*this);
    case OptionKind::input_file:
        return "the path of an existing file";
    case OptionKind::input_folder:
        return "the path of an existing folder";
    case OptionKind::output_name:
        return "a relative path below --out without '..'";
    case OptionKind::component:
        return "{type: …} of kind '" + component_kind + "'" + (optional ? ", or none" : "");
    case OptionKind::components:
        return "a map {name: {type: …}} of kind '" + component_kind + "'" + (auto_rule ? ", or auto" : "");
    case OptionKind::texts:
        return "a list of words";
    case OptionKind::input_files:
        return "a list of paths of existing files";
    case OptionKind::ports:
        return "a map {port: artifact} or {port: {artifact: …, as: …}}";
    }
    return {};
}

std::string OptionDeclaration::default_text() const
{
    if (required)
        return "required";
    if (default_value.is_null())
        return "none";
    return default_value.is_string() && !default_value.as_string().empty() ? default_value.as_string() : to_json(default_value);
}

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
                result.options.push_back(read_option(description));
        result.inputs = read_ports(type.declaration, "inputs");
        result.outputs = read_ports(type.declaration, "outputs");
        result.artifact = text_at(type.declaration, "artifact");
        result.extensions = texts_at(type.declaration, "extensions");
        return result;
    }
    catch (const Error& error)
    {
        throw Error(type.library.string() + ": the description of '" + type.type + "' is not as expected: " + error.what());
    }
}

}  // namespace fresco::host

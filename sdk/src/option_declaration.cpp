#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/option_declaration.h>
#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <set>
#include <string_view>
#include <utility>

namespace fresco
{
namespace
{

/// In the order of OptionKind.
constexpr std::array<std::string_view, 17> kind_names{"bool",         "int",        "number",       "text",         "ints",
                                                      "numbers",      "input_file", "input_folder", "input_path",   "output_name",
                                                      "component",    "components", "input_files",  "command_line", "input_ports",
                                                      "output_ports", "rules"};

/// Bytes that JSON cannot hold as text: in hexadecimal.
template <class Texts>
struct Hex
{
    Texts& texts;
};

template <class T>
constexpr bool has_members = std::is_same_v<T, OptionDeclaration> || std::is_same_v<T, RuleForm> ||
                             std::is_same_v<T, FileFormat> || std::is_same_v<T, Marks>;

/// Calls visit(key, member) for each member, in the order of descriptions; for an option, only for those that its description
/// leaves out at their defaults.
template <class T, class Visit>
void visit_members(T& it, const Visit& visit)
{
    if constexpr (std::is_same_v<T, const OptionDeclaration> || std::is_same_v<T, OptionDeclaration>)
    {
        visit("component_kind", it.component_kind);
        visit("required", it.required);
        visit("default", it.default_value);
        visit("min", it.min);
        visit("max", it.max);
        visit("choices", it.choices);
        visit("extensions", it.extensions);
        visit("formats", it.formats);
        visit("in_key", it.in_key);
        visit("device", it.is_device);
        visit("optional", it.optional);
        visit("chosen_by", it.chosen_by);
        visit("for_form", it.for_form);
        visit("rule", it.rule);
    }
    else if constexpr (requires { it.parts_of; })
    {
        visit("parts_of", it.parts_of);
        visit("word", it.word);
        visit("input", it.input);
        visit("artifact", it.artifact);
        visit("version", it.version);
        visit("number", it.number);
    }
    else if constexpr (requires { it.contains; })
    {
        visit("contains", it.contains);
        visit("formats", it.formats);
        visit("before", it.before);
    }
    else
    {
        visit("name", it.name);
        visit("extensions", it.extensions);
        visit("is_text", it.is_text);
        visit("begins", Hex{it.begins});
        visit("begins_at", it.begins_at);
        visit("holds", Hex{it.holds});
        visit("ends", Hex{it.ends});
        visit("length_at", it.length_at);
        visit("length_bytes", it.length_bytes);
        visit("length_from", it.length_from);
    }
}

template <class T>
Value described(const T& member)
{
    if constexpr (std::is_constructible_v<Value, const T&>)
        return member;
    else if constexpr (has_members<T>)
    {
        Value map = Value::Map{};
        visit_members(member, [&](std::string_view key, const auto& each) { map.set(key, described(each)); });
        return map;
    }
    else if constexpr (requires { member.has_value(); })
        return member ? described(*member) : Value();
    else
    {
        Value::List list;
        if constexpr (requires { member.texts; })
            for (const std::string& text : member.texts)
                list.emplace_back(fmt::format("{:02x}", fmt::join(std::vector<unsigned char>(text.begin(), text.end()), "")));
        else
            for (const auto& each : member)
                list.push_back(described(each));
        return list;
    }
}

template <class T>
void read_member(const Value& value, T& member)
{
    if constexpr (std::is_same_v<T, Value>)
        member = value;
    else if constexpr (std::is_same_v<T, bool>)
        member = value.as_bool();
    else if constexpr (std::is_integral_v<T>)
        member = static_cast<T>(value.as_int());
    else if constexpr (std::is_same_v<T, double>)
        member = value.as_double();
    else if constexpr (std::is_same_v<T, std::string>)
        member = value.as_string();
    else if constexpr (has_members<T>)
        visit_members(member,
                      [&](std::string_view key, auto&& each)
                      {
                          if (const Value* entry = value.find(key))
                              read_member(*entry, each);
                      });
    else if constexpr (requires { member.has_value(); })
        read_member(value, member.emplace());
    else if constexpr (requires { member.texts; })
        for (const Value& text : value.as_list())
        {
            std::string& bytes = member.texts.emplace_back();
            for (std::size_t i = 0; i + 1 < text.as_string().size(); i += 2)
                bytes += static_cast<char>(std::stoi(text.as_string().substr(i, 2), nullptr, 16));
        }
    else
        for (const Value& each : value.as_list())
            read_member(each, member.emplace_back());
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

OptionDeclaration OptionDeclaration::from(const Value& description)
{
    OptionDeclaration option;
    option.name = description.at("name").as_string();
    const std::string& kind = description.at("kind").as_string();
    const auto known = std::ranges::find(kind_names, kind);
    if (known == kind_names.end())
        throw Error("option '" + option.name + "' is of the unknown kind '" + kind + "'");
    option.kind = static_cast<OptionKind>(known - kind_names.begin());
    read_member(description, option);
    option.optional = option.kind == OptionKind::component && (option.default_value.is_null() || option.optional);
    if (option.kind == OptionKind::rules && !option.rule)
        throw Error("option '" + option.name + "' has rules, and does not say of which form");
    if (const Value* help = description.find("help"))
        option.help = help->as_string();
    return option;
}

Value OptionDeclaration::describe() const
{
    Value description = Value::Map{{"name", name}, {"kind", kind_names.at(static_cast<std::size_t>(kind))}};
    static const Value unsaid = described(OptionDeclaration());
    const Value said = described(*this);
    for (const auto& [key, value] : said.as_map())
        if (value != unsaid.at(key))
            description.set(key, value);
    description.set("help", help);
    return description;
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
        return "the path of an existing file" + (extensions.empty() ? "" : " (" + join(extensions, " or ") + ")");
    case OptionKind::input_folder:
        return "the path of an existing folder";
    case OptionKind::input_path:
        return "the path of an existing folder or file";
    case OptionKind::output_name:
        return "a relative path below --out without '..'" + (extensions.empty() ? "" : ", ending in " + join(extensions, " or "));
    case OptionKind::component:
        return "{type: …} of kind '" + component_kind + "'" + (optional ? ", or none" : "") +
               (chosen_by.empty() ? "" : ", or auto: by what '" + chosen_by + "' contains");
    case OptionKind::components:
        return "a map {name: {type: …}} of kind '" + component_kind + "'";
    case OptionKind::input_files:
        return "a list of paths of existing files";
    case OptionKind::command_line:
        return "a list of words";
    case OptionKind::input_ports:
    case OptionKind::output_ports:
        return "a map {port: artifact} or {port: {artifact: …, as: …}}";
    case OptionKind::rules:
        return "a map with a rule for each part: " + rule->word + ", a " + rule->input + ", or {" + rule->input + ": …, " +
               rule->number + ": 0 to 1}";
    }
    return {};
}

std::vector<std::string> OptionDeclaration::inputs_named(const Value& rules) const
{
    std::set<std::string> names;
    for (const auto& [part, each] : rules.as_map())
        if (const std::string& input = each.at(rule->input).as_string(); input != rule->word)
            names.insert(input);
    return {names.begin(), names.end()};
}

std::string OptionDeclaration::default_text() const
{
    if (required)
        return "required";
    if (default_value.is_null())
        return "none";
    return default_value.is_string() && !default_value.as_string().empty() ? default_value.as_string() : to_json(default_value);
}

Value FileFormat::describe() const
{
    return described(*this);
}

FileFormat FileFormat::from(const Value& description)
{
    FileFormat format;
    read_member(description, format);
    return format;
}

Marks Marks::from(const Value& description)
{
    Marks marks;
    read_member(description, marks);
    return marks;
}

Value Marks::describe() const
{
    return described(*this);
}

std::vector<std::string> all_extensions(const std::vector<FileFormat>& formats)
{
    std::vector<std::string> all;
    for (const FileFormat& format : formats)
        for (const std::string& extension : format.extensions)
            if (std::ranges::find(all, extension) == all.end())
                all.push_back(extension);
    return all;
}

FileFormat json_format()
{
    return {.name = "a JSON file", .extensions = {".json"}, .is_text = true, .begins = {"{", "["}, .ends = {"}", "]"}};
}

FileFormat npy_format()
{
    return {.name = "an NPY file", .extensions = {".npy"}, .begins = {"\x93NUMPY"}};
}

FileFormat ply_format()
{
    return {.name = "a PLY mesh", .extensions = {".ply"}, .begins = {"ply\n", "ply\r\n"}, .holds = {"\nend_header"}};
}

FileFormat obj_format()
{
    return {.name = "an OBJ mesh", .extensions = {".obj"}, .is_text = true, .holds = {"\nv ", "\nv\t", "\rv "}};
}

std::vector<FileFormat> picture_formats()
{
    // Programs save pictures of one kind by names of the other.
    const std::vector<std::string> extensions{".png", ".jpg", ".jpeg", ".webp", ".heic", ".heif", ".avif"};
    return {{.name = "a PNG picture", .extensions = extensions, .begins = {"\x89PNG\r\n\x1a\n"}, .ends = {"IEND"}},
            {.name = "a JPEG picture", .extensions = extensions, .begins = {"\xff\xd8\xff"}, .ends = {"\xff\xd9"}},
            {.name = "a WebP picture",
             .extensions = extensions,
             .begins = {"WEBP"},
             .begins_at = 8,
             .length_at = 4,
             .length_bytes = 4,
             .length_from = 8},
            {.name = "a HEIC or AVIF picture", .extensions = extensions, .begins = {"ftyp"}, .begins_at = 4},
            {.name = "a KTX2 texture, which is not read: ktx extract --transcode rgba8 FILE.ktx2 FILE.png makes a picture of it",
             .begins = {"\xabKTX 20\xbb"}}};
}

}  // namespace fresco

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

using KindName = std::pair<std::string_view, OptionKind>;
constexpr std::array kind_names{KindName{"bool", OptionKind::boolean},
                                KindName{"int", OptionKind::integer},
                                KindName{"number", OptionKind::number},
                                KindName{"text", OptionKind::text},
                                KindName{"ints", OptionKind::integers},
                                KindName{"numbers", OptionKind::numbers},
                                KindName{"input_file", OptionKind::input_file},
                                KindName{"input_folder", OptionKind::input_folder},
                                KindName{"input_path", OptionKind::input_path},
                                KindName{"output_name", OptionKind::output_name},
                                KindName{"component", OptionKind::component},
                                KindName{"components", OptionKind::components},
                                KindName{"input_files", OptionKind::input_files},
                                KindName{"command_line", OptionKind::command_line},
                                KindName{"input_ports", OptionKind::input_ports},
                                KindName{"output_ports", OptionKind::output_ports},
                                KindName{"rules", OptionKind::rules}};

Value entry_or(const Value& map, std::string_view key, Value otherwise)
{
    const Value* entry = map.find(key);
    return entry != nullptr ? *entry : std::move(otherwise);
}

std::vector<std::string> texts_at(const Value& map, std::string_view key)
{
    std::vector<std::string> texts;
    if (const Value* list = map.find(key))
        for (const Value& text : list->as_list())
            texts.push_back(text.as_string());
    return texts;
}

std::vector<FileFormat> formats_at(const Value& map)
{
    std::vector<FileFormat> formats;
    if (const Value* list = map.find("formats"))
        for (const Value& format : list->as_list())
            formats.push_back(FileFormat::from(format));
    return formats;
}

Value::List described(const std::vector<FileFormat>& formats)
{
    Value::List list;
    for (const FileFormat& format : formats)
        list.push_back(format.describe());
    return list;
}

Value::List list_of(const std::vector<std::string>& texts)
{
    return {texts.begin(), texts.end()};
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
    const auto known = std::ranges::find(kind_names, kind, &KindName::first);
    if (known == kind_names.end())
        throw Error("option '" + option.name + "' is of the unknown kind '" + kind + "'");
    option.kind = known->second;
    const auto text = [&](std::string_view key) { return entry_or(description, key, "").as_string(); };
    const auto flag = [&](std::string_view key, bool otherwise) { return entry_or(description, key, otherwise).as_bool(); };
    const auto number = [&](std::string_view key)
    {
        const Value* entry = description.find(key);
        return entry != nullptr ? std::optional(entry->as_double()) : std::nullopt;
    };
    option.default_value = entry_or(description, "default", {});
    option.required = flag("required", false);
    option.min = number("min");
    option.max = number("max");
    option.choices = texts_at(description, "choices");
    option.extensions = texts_at(description, "extensions");
    option.formats = formats_at(description);
    option.unit = text("unit");
    option.in_key = flag("in_key", true);
    option.is_device = flag("device", false);
    option.component_kind = text("component_kind");
    option.optional = option.kind == OptionKind::component && (option.default_value.is_null() || flag("optional", false));
    if (const Value* rule = description.find("auto"))
        option.auto_rule = AutoRule{rule->at("option").as_string(), rule->at("if_empty"), rule->at("if_set")};
    option.chosen_by = text("chosen_by");
    option.for_form = text("for_form");
    if (const Value* rule = description.find("rule"))
        option.rule = RuleForm{rule->at("parts_of").as_string(),
                               rule->at("word").as_string(),
                               rule->at("input").as_string(),
                               rule->at("artifact").as_string(),
                               static_cast<int>(rule->at("version").as_int()),
                               rule->at("number").as_string()};
    else if (option.kind == OptionKind::rules)
        throw Error("option '" + option.name + "' has rules, and does not say of which form");
    option.help = text("help");
    return option;
}

Value OptionDeclaration::describe() const
{
    const auto known = std::ranges::find(kind_names, kind, &KindName::second);
    Value description = Value::Map{{"name", name}, {"kind", known->first}};
    const auto say = [&](std::string_view key, const Value& value, const Value& unsaid)
    {
        if (value != unsaid)
            description.set(key, value);
    };
    const auto number = [](const std::optional<double>& bound) { return bound ? Value(*bound) : Value(); };
    say("component_kind", component_kind, "");
    say("required", required, false);
    say("default", required ? Value() : default_value, {});
    say("min", number(min), {});
    say("max", number(max), {});
    say("choices", list_of(choices), Value::List{});
    say("extensions", list_of(extensions), Value::List{});
    say("formats", described(formats), Value::List{});
    say("unit", unit, "");
    say("in_key", in_key, true);
    say("device", is_device, false);
    say("optional", optional, false);
    if (auto_rule)
        description.set(
            "auto", Value::Map{{"option", auto_rule->option}, {"if_empty", auto_rule->if_empty}, {"if_set", auto_rule->if_set}});
    say("chosen_by", chosen_by, "");
    say("for_form", for_form, "");
    if (rule)
        description.set("rule", Value::Map{{"parts_of", rule->parts_of},
                                           {"word", rule->word},
                                           {"input", rule->input},
                                           {"artifact", rule->artifact},
                                           {"version", rule->version},
                                           {"number", rule->number}});
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
        return "a map {name: {type: …}} of kind '" + component_kind + "'" + (auto_rule ? ", or auto" : "");
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

namespace
{

/// JSON is text, bytes are not.
std::string hex_of(std::string_view bytes)
{
    std::string hex;
    for (const char c : bytes)
        hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
    return hex;
}

std::string from_hex(const std::string& hex)
{
    std::string bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
        bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
    return bytes;
}

Value described(const std::vector<std::string>& all)
{
    Value::List list;
    for (const std::string& bytes : all)
        list.push_back(hex_of(bytes));
    return list;
}

std::vector<std::string> read(const Value& list)
{
    std::vector<std::string> all;
    for (const Value& hex : list.as_list())
        all.push_back(from_hex(hex.as_string()));
    return all;
}

std::size_t size_at(const Value& description, std::string_view key)
{
    return static_cast<std::size_t>(description.at(key).as_int());
}

}  // namespace

Value FileFormat::describe() const
{
    return Value::Map{{"name", name},
                      {"extensions", Value::List(extensions.begin(), extensions.end())},
                      {"is_text", is_text},
                      {"begins", described(begins)},
                      {"begins_at", begins_at},
                      {"holds", described(holds)},
                      {"ends", described(ends)},
                      {"length_at", length_at},
                      {"length_bytes", length_bytes},
                      {"length_from", length_from}};
}

FileFormat FileFormat::from(const Value& description)
{
    FileFormat format;
    format.name = description.at("name").as_string();
    format.extensions = texts_at(description, "extensions");
    format.is_text = description.at("is_text").as_bool();
    format.begins = read(description.at("begins"));
    format.begins_at = size_at(description, "begins_at");
    format.holds = read(description.at("holds"));
    format.ends = read(description.at("ends"));
    format.length_at = size_at(description, "length_at");
    format.length_bytes = size_at(description, "length_bytes");
    format.length_from = size_at(description, "length_from");
    return format;
}

Marks Marks::from(const Value& description)
{
    return {texts_at(description, "contains"), formats_at(description), texts_at(description, "before")};
}

Value Marks::describe() const
{
    return Value::Map{{"contains", list_of(contains)}, {"formats", described(formats)}, {"before", list_of(before)}};
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
    return {.name = "an OBJ mesh", .extensions = {".obj"}, .is_text = true, .holds = {"\nv ", "\nv\t"}, .ends = {"\n"}};
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
            {.name = "a HEIC or AVIF picture", .extensions = extensions, .begins = {"ftyp"}, .begins_at = 4}};
}

}  // namespace fresco

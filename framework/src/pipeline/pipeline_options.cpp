#include "pipeline/pipeline_options.h"
#include "base/common.h"
#include "base/file_contents.h"
#include "base/text.h"
#include "pipeline/path_marks.h"
#include <fresco/wording.h>

#include <algorithm>
#include <cmath>
#include <ranges>
#include <unistd.h>

namespace fresco::host
{

namespace
{

/// Defaults may name components whose defaults name components; without an end only by a plugin's mistake.
constexpr std::size_t nesting_limit = 16;

/// A component that is there only for a form in which no port is exchanged is not.
bool is_needed(const OptionDeclaration& option, const TypeDeclaration& type, const Value& values)
{
    if (option.for_form.empty())
        return true;
    for (const OptionDeclaration& ports : type.options)
        if (const Value* value = ports.is_ports() ? values.find(ports.name) : nullptr)
            for (const auto& [name, port] : value->as_map())
                if (port.at("as").as_string() == option.for_form)
                    return true;
    return false;
}

/// The user of a component that the pipeline chooses, in problems.
std::string chosen_for(const std::string& kind)
{
    return "components: '" + kind + "'";
}

/// Otherwise there is a problem already.
bool can_be_read(const fs::path& path)
{
    std::error_code failure;
    return ::access(path.c_str(), fs::is_directory(path, failure) ? R_OK | X_OK : R_OK) == 0;
}

bool is_path(OptionKind kind)
{
    return kind == OptionKind::input_file || kind == OptionKind::input_folder || kind == OptionKind::input_path;
}

/// Words of programs and paths in lists are text whatever they look like.
bool is_as_written(OptionKind kind)
{
    return kind == OptionKind::command_line || kind == OptionKind::input_files;
}

/// The tree that a node stands for; null for scalars that cannot be read.
Value plain_value(const YamlNode& node, OptionKind kind)
{
    if (node.is_list())
        return each<Value>(node.items, [&](const YamlNode& item) { return plain_value(item, kind); });
    if (node.is_map())
    {
        Value::Map map;
        for (const YamlNode::Entry& entry : node.entries)
            map.emplace_back(entry.key, plain_value(entry.value, kind));
        return map;
    }
    if (!node.is_scalar())
        return {};
    // On the command line quotes are the shell's: a number there is text.
    const bool takes_text = is_path(kind) || kind == OptionKind::text || kind == OptionKind::output_name;
    const bool is_text = is_as_written(kind) || (takes_text && node.from_command_line());
    return is_text ? Value(node.text) : resolve_scalar(node).value;
}

/// Only the words of a program may hold several lines.
void check_lines(const YamlNode& node, const std::string& owner, ProblemList& problems)
{
    if (node.is_scalar() && node.text.find_first_of("\n\r\t") != std::string::npos)
        problems.add(node, owner + ": " + node.summary() + " has an end of line or a tab: write it in one line");
    for (const YamlNode& item : node.items)
        check_lines(item, owner, problems);
    for (const YamlNode::Entry& entry : node.entries)
        check_lines(entry.value, owner, problems);
}

const YamlNode& part_of(const YamlNode& node, const std::vector<std::string>& place)
{
    const YamlNode* part = &node;
    for (const std::string& step : place)
        part = part->is_list() ? &part->items[std::stoul(step)] : &part->find(step)->value;
    return *part;
}

std::string problem_text(const OptionDeclaration& option, const ValueProblem& problem, const YamlNode& part)
{
    const std::string expected = problem.expected.empty() ? "" : "; expected " + problem.expected;
    if (!problem.wrong.empty())
        return problem.wrong + expected;
    const ResolvedScalar resolved = part.is_scalar() ? resolve_scalar(part) : ResolvedScalar{};
    if (!resolved.refusal.empty())
        return resolved.refusal + expected;
    const bool braces = part.is_map() && is_as_written(option.kind);
    return "expected " + problem.expected + ", got " + part.summary() +
           (braces ? " (a word with braces is written in quotes)" : "");
}

}  // namespace

OptionChecker::OptionChecker(TypeTable& types, YamlNode components, ProblemList& problems)
    : types_(types), components_(std::move(components)), problems_(problems)
{
    for (YamlNode::Entry& entry : components_.entries)
    {
        const auto& known = types_.pipeline_components();
        const auto names = std::views::keys(known);
        const std::string accepted = "{type: …} of kind '" + entry.key + "', or none";
        OptionUses ignored;
        if (!known.contains(entry.key))
            problems_.add(entry, "no stage takes components of the kind '" + entry.key + "' from the pipeline" +
                                     suggestion(entry.key, {names.begin(), names.end()}));
        else if (entry.value.is_null())
            problems_.add(entry.value, chosen_for(entry.key) + " has no value: leave the line out, or set " + accepted);
        else if (entry.value.is_word("none") ||
                 !complete_component(entry.key, entry.value, {}, chosen_for(entry.key), ignored).is_null())
            continue;
        entry.value.kind = YamlNode::Kind::invalid;
    }
}

Value OptionChecker::complete(const KnownType& type, YamlNode config, const std::vector<std::string>& taken,
                              const std::string& user, OptionUses& uses)
{
    std::vector<std::string> known = type.declaration->option_names();
    known.insert(known.end(), taken.begin(), taken.end());
    for (const YamlNode::Entry& entry : config.entries)
        if (std::ranges::find(known, entry.key) == known.end())
            problems_.add(entry, user + " has no option '" + entry.key + "'" + suggestion(entry.key, known));
    Value result = Value::Map{};
    for (const OptionDeclaration& option : type.declaration->options)
    {
        const YamlNode::Entry* written = config.find(option.name);
        if (written && written->value.is_null())
        {
            problems_.add(*written,
                          user + ": option '" + option.name + "' has no value: leave the line out, or set " + option.accepted());
            continue;
        }
        if (!written && option.required)
        {
            problems_.add(config, user + " needs the option '" + option.name + "': " + option.accepted() +
                                      (option.help.empty() ? "" : " (" + option.help + ")"));
            continue;
        }
        if (!written && option.default_value.is_null())
            continue;
        YamlNode node = written ? written->value : yaml_from_value(option.default_value, config);
        if (!option.chosen_by.empty())
        {
            auto chosen = chosen_by_marks(option, std::move(node), config, result, user);
            if (!chosen)
                continue;
            node = std::move(*chosen);
        }
        if (written && !option.is_slot() && option.kind != OptionKind::command_line)
            check_lines(node, user + ": option '" + option.name + "'", problems_);
        Value value = option.is_slot() ? complete_slot(option, node, user, uses) : check_plain(option, node, user, uses);
        const bool nothing = value.is_null() || (option.kind == OptionKind::output_name && value.as_string().empty());
        if (!nothing)
            result.set(option.name, std::move(value));
    }
    for (const OptionDeclaration& component : type.declaration->components)
        if (is_needed(component, *type.declaration, result))
            if (Value value = pipeline_component(component, config, user, uses); !value.is_null())
                result.set(component.name, std::move(value));
    return result;
}

Value OptionChecker::pipeline_component(const OptionDeclaration& component, const YamlPlace& place, const std::string& user,
                                        OptionUses& uses)
{
    const YamlNode::Entry* chosen = components_.find(component.component_kind);
    if (!chosen)
        return complete_component(component.component_kind,
                                  yaml_from_value(component.default_value, YamlNode(YamlNode::Kind::null, place)), {},
                                  user + ": component '" + component.name + "'", uses);
    if (!chosen->value.is_word("none"))
        return complete_component(component.component_kind, chosen->value, {}, chosen_for(component.component_kind), uses);
    if (!component.optional)
        problems_.add(chosen->value, user + " needs a component of kind '" + component.component_kind + "' (" + component.help +
                                         "): set one by its type");
    return {};
}

std::optional<YamlNode> OptionChecker::chosen_by_marks(const OptionDeclaration& slot, YamlNode node, const YamlNode& config,
                                                       const Value& options, const std::string& user)
{
    const bool is_auto = node.is_scalar() && node.text == "auto";
    const Value* path = options.find(slot.chosen_by);
    if (!path || !can_be_read(path->as_string()))
        return is_auto ? std::nullopt : std::optional(std::move(node));
    const YamlNode::Entry* written = config.find(slot.chosen_by);
    const YamlNode& at = written ? written->value : config;
    const std::string owner = user + ": option '" + slot.chosen_by + "'";
    const MarkedChoice choice =
        choose_by_marks(path->as_string(), slot, is_auto ? "" : type_named_by(node, user, nullptr).value_or(""), types_);
    if (!choice.problem.empty())
        problems_.add(at, owner + ": " + choice.problem, choice.several ? ProblemKind::invalid : ProblemKind::missing_input);
    else if (const KnownType type = types_.find(choice.type, slot.component_kind); type && fs::is_regular_file(path->as_string()))
        check_contents(at, path->as_string(), all_extensions(type.declaration->marks.formats), type.declaration->marks.formats,
                       owner, problems_);
    if (!is_auto)
        return node;
    return choice.type.empty() ? std::nullopt : std::optional(yaml_from_value(choice.type, node));
}

Value OptionChecker::check_plain(const OptionDeclaration& option, const YamlNode& node, const std::string& user, OptionUses& uses)
{
    Value value = value_of(option, node, user, problems_);
    const std::string owner = user + ": option '" + option.name + "'";
    if (option.kind == OptionKind::input_files && !value.is_null())
        for (auto& [name, path] : value.as_map())
        {
            const auto item = std::ranges::find(node.items, name, &YamlNode::text);
            uses.input_files.push_back(check_input_path(item != node.items.end() ? *item : node.find(name)->value,
                                                        OptionKind::input_file, owner, problems_));
            path = uses.input_files.back().string();
        }
    if (option.is_ports() && !value.is_null())
        for (const auto& [name, port] : value.as_map())
            if (const TypeDescription* owner_type = types_.owner_of(port.at("artifact").as_string()))
                uses.components.insert(owner_type);
    if (!value.is_string() || value.as_string().empty())
        return value;
    if (option.kind == OptionKind::input_file)
    {
        uses.input_files.push_back(check_input_path(node, option.kind, owner, problems_));
        check_contents(node, uses.input_files.back(), option.extensions, option.formats, owner, problems_);
    }
    else if (option.kind == OptionKind::input_folder || option.kind == OptionKind::input_path)
        check_input_path(node, option.kind, owner, problems_);
    else if (option.kind == OptionKind::output_name)
        uses.outputs.push_back({value.as_string(), !option.extensions.empty(), option.name, node});
    return value;
}

Value OptionChecker::complete_slot(const OptionDeclaration& option, const YamlNode& node, const std::string& user,
                                   OptionUses& uses)
{
    const bool is_formed = !value_of(option, node, user, problems_).is_null();
    const std::string owner = user + ": option '" + option.name;
    if (option.kind == OptionKind::component)
        return is_formed ? complete_component(option.component_kind, node, {}, owner + "'", uses) : Value();
    Value::Map result;
    for (const YamlNode::Entry& entry : node.entries)
        if (is_formed || (!node.find("type") && (entry.value.is_map() || entry.value.is_scalar())))
            result.emplace_back(entry.key,
                                complete_component(option.component_kind, entry.value, {}, owner + "." + entry.key + "'", uses));
    std::ranges::sort(result, [](const Value::Entry& a, const Value::Entry& b) { return a.first < b.first; });
    return is_formed ? Value(std::move(result)) : Value();
}

Value OptionChecker::complete_component(std::string_view kind, const YamlNode& config, const std::vector<std::string>& taken,
                                        const std::string& user, OptionUses& uses)
{
    if (!config.is_valid())
        return {};
    const std::optional<std::string> name = type_named_by(config, user, &problems_);
    if (!name)
        return {};
    const YamlNode::Entry* written = config.is_map() ? config.find("type") : nullptr;
    const Position at = written ? written->value : config;
    const KnownType type = types_.require(*name, kind, user, at, problems_);
    if (!type)
        return {};
    if (depth_ >= nesting_limit)
    {
        problems_.add(at, user + ": the default components of '" + *name + "' form a cycle", ProblemKind::plugin);
        return {};
    }
    uses.components.insert(type.description);
    std::vector<std::string> keys = taken;
    keys.emplace_back("type");
    ++depth_;
    Value completed = complete(type, config, keys, user + " (" + *name + ")", uses);
    --depth_;
    completed.as_map().insert(completed.as_map().begin(), {"type", *name});
    return completed;
}

Value value_of(const OptionDeclaration& option, const YamlNode& node, const std::string& user, ProblemList& problems)
{
    CheckedValue checked = check_value(option, plain_value(node, option.kind));
    for (const ValueProblem& problem : checked.problems)
        if (const YamlNode& part = part_of(node, problem.place); part.is_valid())
            problems.add(part, user + ": option '" + option.name + "': " + problem_text(option, problem, part));
    if (is_path(option.kind) && checked.value.is_string() && !checked.value.as_string().empty())
        return (node.path_base() / checked.value.as_string()).lexically_normal().string();
    return std::move(checked.value);
}

fs::path check_input_path(const YamlNode& node, OptionKind kind, const std::string& user, ProblemList& problems)
{
    const bool may_be_file = kind != OptionKind::input_folder, may_be_folder = kind != OptionKind::input_file;
    const fs::path path = (node.path_base() / node.text).lexically_normal();
    const auto report = [&](const std::string& text) { problems.add(node, user + ": " + text, ProblemKind::missing_input); };
    const std::string shown = "'" + path.string() + "'";
    std::error_code failure;
    const fs::file_status status = fs::status(path, failure);
    if (!is_utf8(path.string()))
        report(shown + ": the name is not UTF-8 text: rename it");
    else if (const std::string reason = unreachable_text(failure.value()); !reason.empty())
        report(shown + ": " + reason);
    else if (!fs::exists(status))
        report(std::string("no such ") + (!may_be_folder ? "file " : may_be_file ? "folder or file " : "folder ") + shown);
    else if (!may_be_file && !fs::is_directory(status))
        report(shown + " is not a folder");
    else if (!may_be_folder && fs::is_directory(status))
        report(shown + " is a folder, not a file");
    else if (!fs::is_directory(status) && !fs::is_regular_file(status))
        report(shown + " is not a regular file");
    else if (!can_be_read(path))
        report(shown + " cannot be read: check its permissions");
    return path;
}

void check_contents(const YamlNode& node, const fs::path& file, const std::vector<std::string>& extensions,
                    const std::vector<FileFormat>& formats, const std::string& user, ProblemList& problems)
{
    if (const std::string problem = extensions.empty() ? "" : file_problem(file, extensions, formats); !problem.empty())
        problems.add(node, user + ": " + problem, ProblemKind::missing_input);
}

std::string device_option(const TypeDescription& type)
{
    for (const Value& option : type.declaration.at("options").as_list())
        if (option.find("device") != nullptr)
            return option.at("name").as_string();
    return "";
}

void settle_device(const TypeDescription& type, Value& options, bool (*machine_has_gpu)())
{
    if (Value* device = options.find(device_option(type)); device && *device == Value("auto"))
        *device = type.library_versions.find("cuda") && machine_has_gpu() ? "cuda" : "cpu";
}

std::map<std::string, std::string> types_by_marks(const PipelineStage& stage)
{
    std::map<std::string, std::string> types;
    for (const Value& option : stage.type->declaration.at("options").as_list())
        if (option.find("chosen_by"))
            types[option.at("name").as_string()] = stage.options->at(option.at("name").as_string()).at("type").as_string();
    return types;
}

bool works_on_gpu(const PipelineStage& stage)
{
    const Value* device = stage.options->find(device_option(*stage.type));
    return device && (*device == Value("cuda") || *device == Value(true));
}

}  // namespace fresco::host

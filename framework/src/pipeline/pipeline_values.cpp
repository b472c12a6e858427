#include "base/file_contents.h"
#include "base/utf8.h"
#include "pipeline/pipeline_options.h"
#include <fresco/wording.h>

#include <algorithm>
#include <cmath>
#include <unistd.h>

namespace fresco::host
{
namespace
{
namespace fs = std::filesystem;

/// What a user who wrote `node` where `kind` is wanted probably meant.
std::string hint(OptionKind kind, const YamlNode& node, const Value& value)
{
    if (kind == OptionKind::boolean && value.is_string())
    {
        std::string word = value.as_string();
        std::transform(word.begin(), word.end(), word.begin(),
                       [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
        if (word == "yes" || word == "on" || word == "y" || word == "true")
            return " (write true)";
        if (word == "no" || word == "off" || word == "n" || word == "false")
            return " (write false)";
    }
    if (kind == OptionKind::boolean && value.is_int() && (value.as_int() == 0 || value.as_int() == 1))
        return value.as_int() == 1 ? " (write true)" : " (write false)";
    if (kind == OptionKind::integer && value.is_number() && !value.is_int() && std::abs(value.as_double()) < 1e15 &&
        value.as_double() == std::floor(value.as_double()))
        return " (write " + number_text(value.as_double()) + ")";
    if ((kind == OptionKind::integer || kind == OptionKind::number) && value.is_string())
    {
        YamlNode retry = node;
        retry.plain = true;
        std::replace(retry.text.begin(), retry.text.end(), ',', '.');
        std::erase(retry.text, '_');
        std::erase(retry.text, ' ');
        const ResolvedScalar resolved = resolve_scalar(retry);
        if (resolved.refusal.empty() && resolved.value.is_number())
            return retry.text == node.text ? " (without the quotes)" : " (write " + retry.text + ")";
    }
    if ((kind == OptionKind::integers || kind == OptionKind::numbers) && value.is_number())
        return " (write [" + node.text + "])";
    if (kind == OptionKind::text && !value.is_string() && !value.is_null())
        return " (write '" + node.text + "' in quotes)";
    return {};
}

/// How an option reads scalars.
enum class Reading
{
    resolved,    ///< By the rules of YAML.
    text,        ///< The same, but on the command line quotes are the shell's: a number there is text.
    as_written,  ///< Every scalar is text.
};

Reading reading_of(OptionKind kind)
{
    switch (kind)
    {
    case OptionKind::text:
    case OptionKind::input_file:
    case OptionKind::input_folder:
    case OptionKind::output_name:
        return Reading::text;
    case OptionKind::command_line:
    case OptionKind::input_files:
        return Reading::as_written;
    default:
        return Reading::resolved;
    }
}

/// The tree that a node stands for; null for scalars that cannot be read.
Value plain_value(const YamlNode& node, Reading reading)
{
    if (node.is_list())
    {
        Value::List list;
        for (const YamlNode& item : node.items)
            list.push_back(plain_value(item, reading));
        return list;
    }
    if (node.is_map())
    {
        Value::Map map;
        for (const YamlNode::Entry& entry : node.entries)
            map.emplace_back(entry.key, plain_value(entry.value, reading));
        return map;
    }
    if (!node.is_scalar())
        return {};
    const bool is_text = reading == Reading::as_written || (reading == Reading::text && node.from_command_line());
    return is_text ? Value(node.text) : resolve_scalar(node).value;
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
    OptionKind kind = option.kind;
    if (!problem.place.empty() && kind == OptionKind::integers)
        kind = OptionKind::integer;
    if (!problem.place.empty() && kind == OptionKind::numbers)
        kind = OptionKind::number;
    std::string meant = part.is_scalar() ? hint(kind, part, resolved.value) : "";
    if (part.is_map() && reading_of(kind) == Reading::as_written)
        meant = " (a word with braces is written in quotes)";
    return "expected " + problem.expected + ", got " + part.summary() + meant;
}
}  // namespace

Value value_of(const OptionDeclaration& option, const YamlNode& node, const std::string& user, ProblemList& problems)
{
    CheckedValue checked = check_value(option, plain_value(node, reading_of(option.kind)));
    for (const ValueProblem& problem : checked.problems)
        if (const YamlNode& part = part_of(node, problem.place); part.is_valid())
            problems.add(part.position(), user + ": option '" + option.name + "': " + problem_text(option, problem, part));
    const bool is_path = option.kind == OptionKind::input_file || option.kind == OptionKind::input_folder;
    if (is_path && checked.value.is_string() && !checked.value.as_string().empty())
        return (node.path_base() / checked.value.as_string()).lexically_normal().string();
    return std::move(checked.value);
}

fs::path check_input_path(const YamlNode& node, bool folder, const std::string& user, ProblemList& problems)
{
    const fs::path path = (node.path_base() / node.text).lexically_normal();
    const auto report = [&](const std::string& text)
    { problems.add(node.position(), user + ": " + text, ProblemKind::missing_input); };
    const std::string shown = "'" + path.string() + "'";
    std::error_code failure;
    const fs::file_status status = fs::status(path, failure);
    if (!is_utf8(path.string()))
        report(shown + ": the name is not UTF-8 text: rename it");
    else if (!fs::exists(status))
        report(std::string("no such ") + (folder ? "folder " : "file ") + shown);
    else if (folder && !fs::is_directory(status))
        report(shown + " is not a folder");
    else if (!folder && fs::is_directory(status))
        report(shown + " is a folder, not a file");
    else if (!folder && !fs::is_regular_file(status))
        report(shown + " is not a regular file");
    else if (::access(path.c_str(), folder ? R_OK | X_OK : R_OK) != 0)
        report(shown + " cannot be read: check its permissions");
    return path;
}

void check_contents(const YamlNode& node, const fs::path& file, const std::vector<std::string>& extensions,
                    const std::vector<FileFormat>& formats, TypeTable& types, const std::string& user, ProblemList& problems)
{
    const auto others = [&] { return types.formats(); };
    if (const std::string problem = extensions.empty() ? "" : file_problem(file, extensions, formats, others); !problem.empty())
        problems.add(node.position(), user + ": " + problem, ProblemKind::missing_input);
}

}  // namespace fresco::host

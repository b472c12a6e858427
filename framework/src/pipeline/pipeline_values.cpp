#include "base/suggest.h"
#include "pipeline/pipeline_options.h"

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

std::string range_problem(const OptionDeclaration& option, double number)
{
    if (option.min && number < *option.min)
        return number_text(number) + " is too small";
    if (option.max && number > *option.max)
        return number_text(number) + " is too large";
    return {};
}

/// The scalar as the kind of option needs it, or null.
Value as_kind(OptionKind kind, const YamlNode& node, const Value& value)
{
    switch (kind)
    {
    case OptionKind::boolean:
        return value.is_bool() ? value : Value();
    case OptionKind::integer:
        return value.is_int() ? value : Value();
    case OptionKind::number:
        return value.is_number() ? Value(value.as_double()) : Value();
    default:
        break;
    }
    // On the command line quotes are the shell's: a number there is text where text is wanted.
    if (value.is_string() || node.from_command_line())
        return node.text;
    return {};
}

bool is_output_name(const std::string& text)
{
    if (text.find('\\') != std::string::npos || text.back() == '/')
        return false;
    const fs::path path(text);
    return path.is_relative() &&
           std::all_of(path.begin(), path.end(), [](const fs::path& part) { return part != ".." && part != "."; });
}

class ValueChecker
{
  public:
    ValueChecker(const OptionDeclaration& option, const std::string& user, ProblemList& problems)
        : option_(option), prefix_(user + ": option '" + option.name + "': "), problems_(problems)
    {
    }

    Value check(const YamlNode& node)
    {
        if (option_.kind == OptionKind::integers || option_.kind == OptionKind::numbers)
            return check_list(node);
        return check_scalar(option_.kind, node);
    }

  private:
    Value check_list(const YamlNode& node)
    {
        if (!node.is_list())
            return refuse(node);
        const OptionKind each = option_.kind == OptionKind::integers ? OptionKind::integer : OptionKind::number;
        Value::List values;
        bool good = true;
        for (const YamlNode& item : node.items)
        {
            Value value = check_scalar(each, item);
            good = good && !value.is_null();
            values.push_back(std::move(value));
        }
        return good ? Value(std::move(values)) : Value();
    }

    Value check_scalar(OptionKind kind, const YamlNode& node)
    {
        if (!node.is_valid())
            return {};
        if (!node.is_scalar())
            return refuse(node);
        const bool wants_text = kind != OptionKind::boolean && kind != OptionKind::integer && kind != OptionKind::number;
        const ResolvedScalar resolved = resolve_scalar(node);
        if (!resolved.refusal.empty() && !(wants_text && node.from_command_line()))
            return report(node, resolved.refusal + "; expected " + option_.accepted());
        const Value value = as_kind(kind, node, resolved.value);
        if (value.is_null())
            return refuse(node, hint(kind, node, resolved.value));
        return check_domain(node, value);
    }

    Value check_domain(const YamlNode& node, const Value& value)
    {
        if (value.is_number())
        {
            const std::string wrong = range_problem(option_, value.as_double());
            return wrong.empty() ? value : report(node, wrong + "; expected " + option_.accepted());
        }
        if (!value.is_string())
            return value;
        const std::string& text = value.as_string();
        if (!option_.choices.empty() && std::find(option_.choices.begin(), option_.choices.end(), text) == option_.choices.end())
        {
            const std::string meant = nearest(text, option_.choices);
            return report(node, "'" + text + "' is not known" + (meant.empty() ? "" : " (did you mean '" + meant + "'?)") +
                                    "; expected " + option_.accepted());
        }
        if (option_.kind == OptionKind::output_name && !text.empty() && !is_output_name(text))
            return report(node, "'" + text + "' is not accepted; expected " + option_.accepted());
        const bool is_path = option_.kind == OptionKind::input_file || option_.kind == OptionKind::input_folder;
        if (is_path && !text.empty())
            return (node.path_base() / text).lexically_normal().string();
        return value;
    }

    Value refuse(const YamlNode& node, const std::string& hint_text = {})
    {
        if (node.is_valid())
            report(node, "expected " + option_.accepted() + ", got " + node.summary() + hint_text);
        return {};
    }

    Value report(const YamlNode& node, const std::string& text)
    {
        problems_.add(node.position(), prefix_ + text);
        return {};
    }

    const OptionDeclaration& option_;
    std::string prefix_;
    ProblemList& problems_;
};
}  // namespace

Value check_value(const OptionDeclaration& option, const YamlNode& node, const std::string& user, ProblemList& problems)
{
    const bool is_list = option.kind == OptionKind::integers || option.kind == OptionKind::numbers;
    const OptionKind kind = option.kind;
    if (is_list && node.is_scalar())
    {
        const ResolvedScalar resolved = resolve_scalar(node);
        problems.add(node.position(), user + ": option '" + option.name + "': expected " + option.accepted() + ", got " +
                                          node.summary() + hint(kind, node, resolved.value));
        return {};
    }
    return ValueChecker(option, user, problems).check(node);
}

fs::path check_input_path(const YamlNode& node, bool folder, const std::string& user, ProblemList& problems)
{
    const fs::path path = (node.path_base() / node.text).lexically_normal();
    const auto report = [&](const std::string& text)
    { problems.add(node.position(), user + ": " + text, ProblemKind::missing_input); };
    const std::string shown = "'" + path.string() + "'";
    std::error_code failure;
    const fs::file_status status = fs::status(path, failure);
    if (!fs::exists(status))
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

}  // namespace fresco::host

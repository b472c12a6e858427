#include <fresco/option_declaration.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>

namespace fresco
{
namespace
{

/// File systems have no longer names.
constexpr std::size_t most_name_bytes = 255;

/// The problem of a nonempty path below --out; empty if it is valid.
std::string output_name_problem(const std::string& text, const std::vector<std::string>& extensions)
{
    const std::filesystem::path path(text);
    const auto has_part = [&](const char* part) { return std::ranges::find(path, std::filesystem::path(part)) != path.end(); };
    std::string refused = "'" + text + "' is not accepted";
    if (text.find('\\') != std::string::npos)
        return refused + ": its folders are parted by '/', not by '\\'";
    if (path.is_absolute() || has_part(".."))
        return refused;
    if (has_part("."))
        return refused + ": leave out the '.'";
    if (text.back() == '/')
        return refused + ": it names a folder";
    if (std::ranges::any_of(path, [](const auto& part) { return part.native().size() > most_name_bytes; }))
        return refused + fmt::format(": a name has at most {} bytes", most_name_bytes);
    const std::string name = path.filename();
    if (std::ranges::find(extensions, name) != extensions.end())
        return refused + ": there is no name before the extension";
    const bool fits = extensions.empty() ||
                      std::ranges::any_of(extensions, [&](const std::string& extension) { return name.ends_with(extension); });
    return fits ? "" : refused;
}

class ValueChecker
{
  public:
    explicit ValueChecker(const OptionDeclaration& option) : option_(option) {}

    CheckedValue check(const Value& value)
    {
        Value accepted = whole(value);
        return problems_.empty() ? CheckedValue{std::move(accepted), {}} : CheckedValue{{}, std::move(problems_)};
    }

  private:
    Value whole(const Value& value)
    {
        switch (option_.kind)
        {
        case OptionKind::boolean:
            return value.is_bool() ? value : wrong_kind();
        case OptionKind::integer:
        case OptionKind::number:
            return number(value, option_.kind);
        case OptionKind::integers:
            return numbers(value, OptionKind::integer);
        case OptionKind::numbers:
            return numbers(value, OptionKind::number);
        case OptionKind::text:
        case OptionKind::input_file:
        case OptionKind::input_folder:
        case OptionKind::input_path:
        case OptionKind::output_name:
            return value.is_string() ? text(value) : wrong_kind();
        case OptionKind::component:
            return component(value);
        case OptionKind::components:
            return components(value);
        case OptionKind::command_line:
            return words(value);
        case OptionKind::input_files:
            return files(value);
        case OptionKind::input_ports:
        case OptionKind::output_ports:
            return ports(value);
        case OptionKind::rules:
            return rules(value);
        }
        return {};
    }

    Value number(const Value& value, OptionKind kind)
    {
        if (kind == OptionKind::integer ? !value.is_int() : !value.is_number() || !std::isfinite(value.as_double()))
            return wrong_kind();
        const double given = value.as_double();
        if (option_.min && given < *option_.min)
            return refuse(number_text(given) + " is too small");
        if (option_.max && given > *option_.max)
            return refuse(number_text(given) + " is too large");
        return kind == OptionKind::integer ? value : Value(given);
    }

    Value numbers(const Value& value, OptionKind each)
    {
        if (!value.is_list())
            return wrong_kind();
        Value::List accepted;
        for (std::size_t i = 0; i < value.as_list().size(); ++i)
        {
            place_ = {std::to_string(i)};
            accepted.push_back(number(value.as_list()[i], each));
        }
        return accepted;
    }

    Value text(const Value& value)
    {
        const std::string& given = value.as_string();
        if (!option_.choices.empty() && std::ranges::find(option_.choices, given) == option_.choices.end())
        {
            const std::string meant = nearest(given, option_.choices);
            return refuse("'" + given + "' is not known" + (meant.empty() ? "" : " (did you mean '" + meant + "'?)"));
        }
        // Without a name there is no file, which only an option that need not name one leaves so.
        if (option_.kind == OptionKind::output_name && given.empty() && option_.default_value != Value(""))
            return refuse("'' is not accepted");
        if (option_.kind == OptionKind::output_name && !given.empty())
            if (const std::string problem = output_name_problem(given, option_.extensions); !problem.empty())
                return refuse(problem);
        return value;
    }

    Value component(const Value& value)
    {
        if (option_.optional && value == Value("none"))
            return {};
        return value.is_string() || value.is_map() ? value : wrong_kind();
    }

    Value components(const Value& value)
    {
        if (!value.is_map())
            return wrong_kind();
        if (const Value* type = value.find("type"); type != nullptr && type->is_string())
            return refuse("several components are expected: give each a name, {name: {type: …}}", "");
        for (const auto& [name, config] : value.as_map())
        {
            place_ = {name};
            if (config.is_null())
                refuse("'" + name + "' has no value: set {type: …}, or leave the line out", "");
            else if (!config.is_string() && !config.is_map())
                refuse("", "{type: …} of kind '" + option_.component_kind + "'");
        }
        return value;
    }

    Value words(const Value& value)
    {
        if (!value.is_list())
            return wrong_kind();
        for (std::size_t i = 0; i < value.as_list().size(); ++i)
            if (!value.as_list()[i].is_string())
                refuse_at(std::to_string(i), "a word");
        return value;
    }

    /// A list as written, or the map that is made of it.
    Value files(const Value& value)
    {
        if (value.is_map())
        {
            for (const auto& [name, path] : value.as_map())
                if (!path.is_string())
                    refuse_at(name, "a path");
            return value;
        }
        if (words(value).is_null())
            return {};
        Value by_name = Value::Map{};
        for (const Value& file : value.as_list())
            if (file.is_string())
                by_name.set(file.as_string(), file);
        return by_name;
    }

    Value ports(const Value& value)
    {
        if (!value.is_map())
            return wrong_kind();
        Value accepted = Value::Map{};
        for (const auto& [name, written] : value.as_map())
        {
            place_ = {name};
            accepted.set(name, port(name, written));
        }
        return accepted;
    }

    Value port(const std::string& name, const Value& written)
    {
        const std::string where = "port '" + name + "'";
        if (!is_name(name))
            return refuse(where + ": a name is made of letters, digits, '_' and '-'", "");
        const Value* inner = written.find("artifact");
        const Value& named = inner != nullptr ? *inner : written;
        if (!named.is_string() || named.as_string().empty())
            return refuse(where + ": expected an artifact such as mesh, or {artifact: …, as: …}", "");
        const std::string& artifact = named.as_string();
        if (inner != nullptr)
            place_ = {name, "artifact"};
        const auto known = option_.artifacts.find(artifact);
        if (known == option_.artifacts.end())
        {
            std::vector<std::string> names;
            for (const auto& [each, form] : option_.artifacts)
                names.push_back(each);
            return refuse(where + ": unknown artifact '" + artifact + "'" + suggestion(artifact, names), "");
        }
        const std::vector<std::string>& forms = known->second.as;
        Value result =
            Value::Map{{"artifact", artifact}, {"version", known->second.version}, {"as", forms.empty() ? "" : forms.front()}};
        for (const auto& [key, entry] : inner != nullptr ? written.as_map() : Value::Map{})
        {
            place_ = {name, key};
            if (key == "artifact" || (key == "version" && entry == result.at("version")))
                continue;
            if (key != "as")
                return refuse(where + " has no '" + key + "'" + suggestion(key, {"artifact", "as"}), "");
            if (forms.empty() && entry != Value(""))
                return refuse(where + ": " + artifact + " has only one form; leave 'as' out", "");
            if (!forms.empty() &&
                std::ranges::none_of(forms, [&as = entry](const std::string& form) { return as == Value(form); }))
                return refuse("", "one of " + join(forms, ", ") + " for 'as' of " + where);
            result.set("as", entry);
        }
        return result;
    }

    Value rules(const Value& value)
    {
        if (!value.is_map())
            return wrong_kind();
        if (value.as_map().empty())
            return refuse("no part has a rule");
        Value::Map accepted;
        for (const auto& [part, written] : value.as_map())
        {
            place_ = {part};
            if (std::ranges::find(accepted, part, &Value::Entry::first) != accepted.end())
                refuse("'" + part + "' has two rules", "one rule for each part");
            accepted.emplace_back(part, rule(part, written));
        }
        // Their order means nothing.
        std::ranges::sort(accepted, {}, &Value::Entry::first);
        return accepted;
    }

    Value rule(const std::string& part, const Value& written)
    {
        const RuleForm& form = *option_.rule;
        const std::string expected =
            fmt::format("{0}, the name of a {1}, or {{{1}: …, {2}: …}}", form.word, form.input, form.number);
        const Value* inner = written.find(form.input);
        const Value& named = inner != nullptr ? *inner : written;
        if (!named.is_string())
            return refuse("the rule for '" + part + "' names no " + form.input, expected);
        if (inner != nullptr)
            place_ = {part, form.input};
        const std::string& name = named.as_string();
        if (!is_name(name))
            return refuse("'" + name + "' cannot name a " + form.input + ": a name is made of letters, digits, '_' and '-'", "");
        double number = 1;
        for (const auto& [key, entry] : inner != nullptr ? written.as_map() : Value::Map{})
        {
            place_ = {part, key};
            if (key == form.input)
                continue;
            if (key != form.number)
                return refuse("the rule for '" + part + "' has no '" + key + "'" + suggestion(key, {form.input, form.number}),
                              "");
            if (!entry.is_number() || !(entry.as_double() >= 0 && entry.as_double() <= 1))
                return refuse("", "a number from 0 to 1 for '" + form.number + "' of '" + part + "'");
            number = entry.as_double();
            if (name == form.word && number != 1)
                return refuse("the rule for '" + part + "' is '" + form.word + "', which has no " + form.number, "");
        }
        return Value::Map{{form.input, name}, {form.number, number}};
    }

    void refuse_at(const std::string& place, const std::string& expected)
    {
        place_ = {place};
        refuse("", expected);
    }
    Value wrong_kind() { return refuse(""); }
    Value refuse(std::string wrong) { return refuse(std::move(wrong), option_.accepted()); }
    Value refuse(std::string wrong, std::string expected)
    {
        problems_.push_back({place_, std::move(wrong), std::move(expected)});
        return {};
    }

    const OptionDeclaration& option_;
    std::vector<std::string> place_;
    std::vector<ValueProblem> problems_;
};

}  // namespace

CheckedValue check_value(const OptionDeclaration& option, const Value& value)
{
    return ValueChecker(option).check(value);
}

}  // namespace fresco

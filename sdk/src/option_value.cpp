#include <fresco/option_declaration.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>

namespace fresco
{
namespace
{

/// What is wrong with a path below --out that is not empty; empty if nothing is.
std::string output_name_problem(const std::string& text)
{
    const std::filesystem::path path(text);
    const auto has_part = [&](const char* part) { return std::ranges::find(path, std::filesystem::path(part)) != path.end(); };
    const std::string refused = "'" + text + "' is not accepted";
    if (text.find('\\') != std::string::npos)
        return refused + ": its folders are parted by '/', not by '\\'";
    if (path.is_absolute() || has_part(".."))
        return refused;
    if (has_part("."))
        return refused + ": leave out the '.'";
    return text.back() == '/' ? refused + ": it names a folder" : "";
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
        case OptionKind::output_name:
            return value.is_string() ? text(value) : wrong_kind();
        case OptionKind::component:
            return component(value);
        case OptionKind::components:
            return components(value);
        case OptionKind::texts:
        case OptionKind::input_files:
        case OptionKind::ports:
            return value;
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
            if (const std::string problem = output_name_problem(given); !problem.empty())
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
                refuse("'" + name + "' has no value: give {type: …}, or leave the line out", "");
            else if (!config.is_string() && !config.is_map())
                problems_.push_back({place_, "", "{type: …} of kind '" + option_.component_kind + "'"});
        }
        return value;
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

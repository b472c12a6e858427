#include <fresco/error.h>
#include <fresco/option.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco
{
namespace
{

[[noreturn]] void refuse(const std::string& option, const Value& value, const std::string& expected)
{
    throw Error("option \"" + option + "\": " + to_json(value) + " is not accepted; expected " + expected);
}

std::string range_text(const Range& range)
{
    const auto text = [](double number)
    { return to_json(number == std::floor(number) ? Value(static_cast<std::int64_t>(number)) : Value(number)); };
    if (std::isinf(range.max))
        return "at least " + text(range.min);
    return text(range.min) + " to " + text(range.max);
}

double checked_number(const std::string& option, const Value& value, const std::optional<Range>& accepted)
{
    if (!value.is_number() || !std::isfinite(value.as_double()))
        refuse(option, value, "a number");
    const double number = value.as_double();
    if (accepted && (number < accepted->min || number > accepted->max))
        refuse(option, value, range_text(*accepted));
    return number;
}

Range narrowed_to_int(const std::optional<Range>& accepted)
{
    constexpr double least = std::numeric_limits<int>::min();
    constexpr double greatest = std::numeric_limits<int>::max();
    const Range wanted = accepted.value_or(Range{least, greatest});
    return {std::max(wanted.min, least), std::min(wanted.max, greatest)};
}

/// What is accepted and fits the type, so that a check without the plugin refuses what the plugin would.
template <class T>
std::optional<Range> narrowed(const std::optional<Range>& accepted)
{
    if constexpr (std::is_same_v<T, int> || std::is_same_v<T, std::vector<int>>)
        return narrowed_to_int(accepted);
    else
        return accepted;
}

std::int64_t checked_integer(const std::string& option, const Value& value, const std::optional<Range>& accepted)
{
    if (!value.is_int())
        refuse(option, value, "a whole number");
    checked_number(option, value, accepted);
    return value.as_int();
}

/// How one C++ type is named in descriptions, written as a Value and read back.
template <class T>
struct Kind;

template <>
struct Kind<bool>
{
    static constexpr const char* name = "bool";
    static Value write(bool v) { return v; }
    static bool read(const std::string& option, const Value& value, const std::optional<Range>&)
    {
        if (!value.is_bool())
            refuse(option, value, "true or false");
        return value.as_bool();
    }
};

template <>
struct Kind<int>
{
    static constexpr const char* name = "int";
    static Value write(int v) { return v; }
    static int read(const std::string& option, const Value& value, const std::optional<Range>& accepted)
    {
        return static_cast<int>(checked_integer(option, value, narrowed_to_int(accepted)));
    }
};

template <>
struct Kind<std::int64_t>
{
    static constexpr const char* name = "int";
    static Value write(std::int64_t v) { return v; }
    static std::int64_t read(const std::string& option, const Value& value, const std::optional<Range>& accepted)
    {
        return checked_integer(option, value, accepted);
    }
};

template <>
struct Kind<double>
{
    static constexpr const char* name = "number";
    static Value write(double v) { return v; }
    static double read(const std::string& option, const Value& value, const std::optional<Range>& accepted)
    {
        return checked_number(option, value, accepted);
    }
};

template <>
struct Kind<std::string>
{
    static constexpr const char* name = "text";
    static Value write(const std::string& v) { return v; }
    static std::string read(const std::string& option, const Value& value, const std::optional<Range>&)
    {
        if (!value.is_string())
            refuse(option, value, "text");
        return value.as_string();
    }
};

template <class Element>
struct ListKind
{
    static Value write(const std::vector<Element>& v) { return Value::List(v.begin(), v.end()); }
    static std::vector<Element> read(const std::string& option, const Value& value, const std::optional<Range>& accepted)
    {
        if (!value.is_list())
            refuse(option, value, "a list");
        std::vector<Element> result;
        for (const Value& element : value.as_list())
            result.push_back(Kind<Element>::read(option, element, accepted));
        return result;
    }
};

template <>
struct Kind<std::vector<int>> : ListKind<int>
{
    static constexpr const char* name = "ints";
};

template <>
struct Kind<std::vector<double>> : ListKind<double>
{
    static constexpr const char* name = "numbers";
};

template <class Path>
struct PathKind
{
    static Value write(const Path& v) { return v.path.string(); }
    static Path read(const std::string& option, const Value& value, const std::optional<Range>&)
    {
        if (!value.is_string())
            refuse(option, value, "a path");
        return Path{value.as_string()};
    }
};

template <>
struct Kind<InputFile> : PathKind<InputFile>
{
    static constexpr const char* name = "input_file";
};

template <>
struct Kind<InputFolder> : PathKind<InputFolder>
{
    static constexpr const char* name = "input_folder";
};

template <>
struct Kind<OutputName>
{
    static constexpr const char* name = "output_name";
    static Value write(const OutputName& v) { return v.path; }
    static OutputName read(const std::string& option, const Value& value, const std::optional<Range>&)
    {
        const std::filesystem::path path = value.is_string() ? value.as_string() : "";
        if (path.empty() || path.is_absolute() || std::ranges::find(path, std::filesystem::path("..")) != path.end())
            refuse(option, value, "a relative path without \"..\"");
        return {path.generic_string()};
    }
};

std::string unit_of(const std::string& name)
{
    static constexpr std::array units{"px", "m", "deg", "count", "s", "mb"};
    for (const char* unit : units)
        if (name.ends_with(std::string("_") + unit))
            return unit;
    return {};
}

}  // namespace

template <class T>
Value Option<T>::describe() const
{
    Value description = Value::Map{{"name", name()}, {"kind", Kind<T>::name}};
    if (required_)
        description.set("required", true);
    else
        description.set("default", Kind<T>::write(default_));
    if (const std::optional<Range> accepted = narrowed<T>(range_))
    {
        if (std::isfinite(accepted->min))
            description.set("min", accepted->min);
        if (std::isfinite(accepted->max))
            description.set("max", accepted->max);
    }
    if (!words_.empty())
        description.set("choices", Value::List(words_.begin(), words_.end()));
    if (const std::string unit = unit_of(name()); !unit.empty())
        description.set("unit", unit);
    if (!in_key_)
        description.set("in_key", false);
    description.set("help", help());
    return description;
}

template <class T>
void Option<T>::assign(const Value& value, ComponentFactory&)
{
    T read = Kind<T>::read(name(), value, range_);
    if constexpr (std::is_same_v<T, std::string>)
        if (!words_.empty() && std::ranges::find(words_, read) == words_.end())
        {
            std::string expected = "one of";
            for (const std::string& word : words_)
                expected += " " + word;
            refuse(name(), value, expected);
        }
    value_ = std::move(read);
}

template class Option<bool>;
template class Option<int>;
template class Option<std::int64_t>;
template class Option<double>;
template class Option<std::string>;
template class Option<std::vector<int>>;
template class Option<std::vector<double>>;
template class Option<InputFile>;
template class Option<InputFolder>;
template class Option<OutputName>;

}  // namespace fresco

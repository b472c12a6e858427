#include <fresco/option.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco
{
namespace
{

/// How one C++ type is declared, written as a Value and read back from one that was checked.
template <class T>
struct Kind;

template <>
struct Kind<bool>
{
    static constexpr OptionKind kind = OptionKind::boolean;
    static Value write(bool v) { return v; }
    static bool read(const Value& value) { return value.as_bool(); }
};

template <>
struct Kind<int>
{
    static constexpr OptionKind kind = OptionKind::integer;
    static Value write(int v) { return v; }
    static int read(const Value& value) { return static_cast<int>(value.as_int()); }
};

template <>
struct Kind<std::int64_t>
{
    static constexpr OptionKind kind = OptionKind::integer;
    static Value write(std::int64_t v) { return v; }
    static std::int64_t read(const Value& value) { return value.as_int(); }
};

template <>
struct Kind<double>
{
    static constexpr OptionKind kind = OptionKind::number;
    static Value write(double v) { return v; }
    static double read(const Value& value) { return value.as_double(); }
};

template <>
struct Kind<std::string>
{
    static constexpr OptionKind kind = OptionKind::text;
    static Value write(const std::string& v) { return v; }
    static std::string read(const Value& value) { return value.as_string(); }
};

template <class Element>
struct Kind<std::vector<Element>>
{
    static constexpr OptionKind kind = std::is_same_v<Element, int> ? OptionKind::integers : OptionKind::numbers;
    static Value write(const std::vector<Element>& v) { return Value::List(v.begin(), v.end()); }
    static std::vector<Element> read(const Value& value)
    {
        std::vector<Element> result;
        for (const Value& element : value.as_list())
            result.push_back(Kind<Element>::read(element));
        return result;
    }
};

template <class Path, OptionKind its_kind>
struct PathKind
{
    static constexpr OptionKind kind = its_kind;
    static Value write(const Path& v) { return std::filesystem::path(v.path).generic_string(); }
    static Path read(const Value& value) { return Path{value.as_string()}; }
};

template <>
struct Kind<InputFile> : PathKind<InputFile, OptionKind::input_file>
{
};

template <>
struct Kind<InputFolder> : PathKind<InputFolder, OptionKind::input_folder>
{
};

template <>
struct Kind<OutputName> : PathKind<OutputName, OptionKind::output_name>
{
};

std::string unit_of(const std::string& name)
{
    static constexpr std::array units{"px", "m", "deg", "count", "s", "mb"};
    for (const char* unit : units)
        if (name.ends_with(std::string("_") + unit))
            return unit;
    return {};
}

template <class T>
OptionDeclaration completed(OptionDeclaration option, const T& value)
{
    option.kind = Kind<T>::kind;
    option.unit = unit_of(option.name);
    if (!option.required)
        option.default_value = Kind<T>::write(value);
    if constexpr (std::is_same_v<T, int> || std::is_same_v<T, std::vector<int>>)
    {
        // What fits the type: a check without the plugin refuses what the plugin would.
        constexpr double least = std::numeric_limits<int>::min();
        constexpr double greatest = std::numeric_limits<int>::max();
        option.min = std::max(option.min.value_or(least), least);
        option.max = std::min(option.max.value_or(greatest), greatest);
    }
    for (std::optional<double>* bound : {&option.min, &option.max})
        if (*bound && std::isinf(**bound))
            bound->reset();
    return option;
}

}  // namespace

template <class T>
Option<T>::Option(Configurable* owner, T value, OptionDeclaration declaration)
    : Parameter(owner, completed(std::move(declaration), value)), value_(std::move(value))
{
}

template <class T>
void Option<T>::set(const Value& value, ComponentFactory&)
{
    value_ = Kind<T>::read(value);
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

#include <fresco/option.h>

#include <algorithm>
#include <cmath>
#include <ranges>

namespace fresco
{
namespace
{

struct Kinds
{
    static constexpr OptionKind of(const bool*) { return OptionKind::boolean; }
    static constexpr OptionKind of(const int*) { return OptionKind::integer; }
    static constexpr OptionKind of(const std::int64_t*) { return OptionKind::integer; }
    static constexpr OptionKind of(const double*) { return OptionKind::number; }
    static constexpr OptionKind of(const std::string*) { return OptionKind::text; }
    static constexpr OptionKind of(const std::vector<int>*) { return OptionKind::integers; }
    static constexpr OptionKind of(const std::vector<double>*) { return OptionKind::numbers; }
    static constexpr OptionKind of(const InputFile*) { return OptionKind::input_file; }
    static constexpr OptionKind of(const InputFiles*) { return OptionKind::input_files; }
    static constexpr OptionKind of(const InputFolder*) { return OptionKind::input_folder; }
    static constexpr OptionKind of(const InputPath*) { return OptionKind::input_path; }
    static constexpr OptionKind of(const CommandLine*) { return OptionKind::command_line; }
    static constexpr OptionKind of(const OutputName*) { return OptionKind::output_name; }
};

template <class T>
constexpr OptionKind kind_of = Kinds::of(static_cast<const T*>(nullptr));

template <class T>
Value written(const T& v)
{
    if constexpr (std::is_same_v<T, InputFile> || std::is_same_v<T, InputFolder> || std::is_same_v<T, InputPath>)
        return v.path.string();
    else if constexpr (std::is_same_v<T, OutputName>)
        return v.path;
    else if constexpr (std::is_same_v<T, CommandLine>)
        return Value::List(v.words.begin(), v.words.end());
    else if constexpr (std::is_same_v<T, InputFiles>)
        return Value::List(std::views::keys(v.paths).begin(), std::views::keys(v.paths).end());
    else if constexpr (kind_of<T> == OptionKind::integers || kind_of<T> == OptionKind::numbers)
        return Value::List(v.begin(), v.end());
    else
        return v;
}

/// From a value that was checked.
template <class T>
void read(const Value& value, T& v)
{
    if constexpr (std::is_same_v<T, bool>)
        v = value.as_bool();
    else if constexpr (std::is_integral_v<T>)
        v = static_cast<T>(value.as_int());
    else if constexpr (std::is_same_v<T, double>)
        v = value.as_double();
    else if constexpr (std::is_same_v<T, std::string>)
        v = value.as_string();
    else if constexpr (std::is_same_v<T, CommandLine>)
        read(value, v.words);
    else if constexpr (std::is_same_v<T, InputFiles>)
    {
        v.paths.clear();
        for (const auto& [name, path] : value.as_map())
            v.paths[name] = path.as_string();
    }
    else if constexpr (requires { v.path; })
        v.path = value.as_string();
    else
    {
        v.clear();
        for (const Value& element : value.as_list())
            read(element, v.emplace_back());
    }
}

void declare(OptionDeclaration& option, NotInKey)
{
    option.in_key = false;
}
void declare(OptionDeclaration& option, ChoosesDevice)
{
    option.is_device = true;
}
void declare(OptionDeclaration& option, const Range* accepted)
{
    option.min = accepted->min;
    option.max = accepted->max;
}
void declare(OptionDeclaration& option, const OneOf* accepted)
{
    option.choices = accepted->words;
}
void declare(OptionDeclaration& option, const Extensions* accepted)
{
    option.extensions = accepted->extensions;
    option.formats = accepted->formats;
}
void declare(OptionDeclaration& option, const char* help)
{
    option.help = help;
}

template <class T>
OptionDeclaration declared(std::string name, bool is_required, const T& value, std::initializer_list<detail::OptionTerm> said)
{
    OptionDeclaration option{.name = std::move(name), .kind = kind_of<T>, .required = is_required};
    for (const detail::OptionTerm& term : said)
        std::visit([&](const auto what) { declare(option, what); }, term.said);
    if (!option.required)
        option.default_value = written(value);
    if constexpr (std::is_same_v<T, int> || std::is_same_v<T, std::vector<int>>)
    {
        // Limits of the type: a check without the plugin refuses what the plugin would.
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

namespace detail
{
OptionTerm::OptionTerm(const Range& accepted) : said(&accepted) {}
OptionTerm::OptionTerm(const OneOf& accepted) : said(&accepted) {}
OptionTerm::OptionTerm(const Extensions& accepted) : said(&accepted) {}
OptionTerm::OptionTerm(NotInKey mark) : said(mark) {}
OptionTerm::OptionTerm(ChoosesDevice mark) : said(mark) {}
OptionTerm::OptionTerm(const char* help) : said(help) {}
OptionTerm::OptionTerm(const std::string& help) : said(help.c_str()) {}
}  // namespace detail

template <class T>
Option<T>::Option(Configurable* owner, std::string name, bool is_required, T value,
                  std::initializer_list<detail::OptionTerm> said)
    : Parameter(owner, declared(std::move(name), is_required, value, said)), value_(std::move(value))
{
}

template <class T>
void Option<T>::set(const Value& value, ComponentFactory&)
{
    read(value, value_);
}

template class Option<bool>;
template class Option<int>;
template class Option<std::int64_t>;
template class Option<double>;
template class Option<std::string>;
template class Option<std::vector<int>>;
template class Option<std::vector<double>>;
template class Option<InputFile>;
template class Option<InputFiles>;
template class Option<CommandLine>;
template class Option<InputFolder>;
template class Option<InputPath>;
template class Option<OutputName>;

}  // namespace fresco

#pragma once

#include <fresco/component.h>
#include <fresco/option_declaration.h>

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

/// \file Options: declared once as members; parsing, validation, `describe`, docs, editor schema and cache key come from that.

namespace fresco
{

/// A file that must exist when the pipeline is checked. Its contents enter the cache key. Empty = not given.
struct InputFile
{
    std::filesystem::path path;
    bool empty() const { return path.empty(); }
};

/// A folder that must exist when the pipeline is checked. What the stage reads in it enters the cache key through
/// RunContext::reads_file and RunContext::reads_folder.
struct InputFolder
{
    std::filesystem::path path;
    bool empty() const { return path.empty(); }
};

/// A folder or a file that must exist when the pipeline is checked; for the cache key, as an InputFolder.
struct InputPath
{
    std::filesystem::path path;
    bool empty() const { return path.empty(); }
};

/// Files that must exist when the pipeline is checked: a list. Their contents enter the cache key, not where they lie.
struct InputFiles
{
    std::map<std::string, std::filesystem::path> paths{};  ///< Each by its name in the pipeline.
};

/// A program and its words, not through a shell: a list. A word that is spelled like a file of the stage's InputFiles is that
/// file; {name} stands for such a file or for the path of a port. check_command_line says what is checked before the stage runs.
struct CommandLine
{
    std::vector<std::string> words{};
};

/// A relative path below `--out`, without `..`.
struct OutputName
{
    std::string path;
};

/// Closed range of accepted numbers; for a list: of each entry.
struct Range
{
    double min;
    double max;
};
constexpr Range range(double min, double max)
{
    return {min, max};
}
constexpr Range at_least(double min)
{
    return {min, std::numeric_limits<double>::infinity()};
}

/// The accepted words of a text option.
struct OneOf
{
    std::vector<std::string> words;
};
inline OneOf one_of(std::initializer_list<const char*> words)
{
    return {{words.begin(), words.end()}};
}

/// Extensions of the file that an OutputName names or an InputFile may be, lower case, with the dot: ".png".
struct Extensions
{
    std::vector<std::string> extensions;
    std::vector<FileFormat> formats{};
};
inline Extensions extensions(std::initializer_list<const char*> accepted)
{
    return {{accepted.begin(), accepted.end()}};
}
/// Extensions of an InputFile's formats. fresco check refuses a file that does not begin as its extension says, is empty or cut
/// short.
inline Extensions formats(std::vector<FileFormat> accepted)
{
    Extensions result{all_extensions(accepted)};
    result.formats = std::move(accepted);
    return result;
}

/// In place of a default: the pipeline must give a value.
struct Required
{
};
inline constexpr Required required{};

/// Last argument of an option whose value cannot change the result (how often a preview is written, …): not in the cache key.
struct NotInKey
{
};
inline constexpr NotInKey not_in_key{};

/// Last argument of the option that says whether the stage works on a GPU: true, or the text "cuda". Its "auto" becomes "cuda" or
/// "cpu" before anything runs, so that the key of a result says where it was made.
struct ChoosesDevice
{
};
inline constexpr ChoosesDevice chooses_device{};

namespace detail
{
/// One of the arguments that describe an option. Refers to it, so it must not outlive the constructor's call. The declaration is
/// put together in the library: compiled here, each option of each stage would have its own copy of that code.
struct OptionTerm
{
    OptionTerm(const Range& accepted);
    OptionTerm(const OneOf& accepted);
    OptionTerm(const Extensions& accepted);
    OptionTerm(NotInKey);
    OptionTerm(ChoosesDevice);
    OptionTerm(const char* help);
    OptionTerm(const std::string& help);

    std::variant<NotInKey, ChoosesDevice, const Range*, const OneOf*, const Extensions*, const char*> said;
};

template <class... Terms>
inline constexpr bool has_one_help = (int{std::is_convertible_v<Terms, std::string>} + ... + 0) == 1;
}  // namespace detail

/// A setting of one of the types bool, int, std::int64_t, double, std::string, std::vector<int>, std::vector<double>, InputFile,
/// InputFiles, InputFolder, InputPath, CommandLine, OutputName. `*option` is the value, valid from configure() on (in `run` and
/// `prepare`), the default before. After name and default (or fresco::required): what is accepted, where that is less than the
/// type holds (range, at_least, one_of, extensions); a line of help; not_in_key where the value cannot change the result; and
/// chooses_device.
template <class T>
class Option final : public Parameter
{
  public:
    template <class... More>
    Option(Configurable* owner, std::string name, T value, const More&... more)
        : Option(owner, std::move(name), false, std::move(value), {more...})
    {
        static_assert(detail::has_one_help<More...>, "an option has one line of help");
    }
    template <class... More>
    Option(Configurable* owner, std::string name, Required, const More&... more)
        : Option(owner, std::move(name), true, T{}, {more...})
    {
        static_assert(detail::has_one_help<More...>, "an option has one line of help");
    }

    const T& operator*() const { return value_; }
    const T* operator->() const { return &value_; }

  private:
    Option(Configurable* owner, std::string name, bool is_required, T value, std::initializer_list<detail::OptionTerm> said);
    void set(const Value& value, ComponentFactory& factory) override;

    T value_;
};

extern template class Option<bool>;
extern template class Option<int>;
extern template class Option<std::int64_t>;
extern template class Option<double>;
extern template class Option<std::string>;
extern template class Option<std::vector<int>>;
extern template class Option<std::vector<double>>;
extern template class Option<InputFile>;
extern template class Option<InputFiles>;
extern template class Option<CommandLine>;
extern template class Option<InputFolder>;
extern template class Option<InputPath>;
extern template class Option<OutputName>;

/// A text option whose words stand for the values of an enumeration: `*option` is that value.
template <class Enum>
class Choice final
{
  public:
    using Words = std::vector<std::pair<std::string, Enum>>;
    template <class... More>
    Choice(Configurable* owner, std::string name, Enum value, const Words& words, std::string help, const More&... more)
        : words_(words), option_(owner, std::move(name), word(value), accepted(), std::move(help), more...)
    {
    }

    Enum operator*() const
    {
        for (const auto& [word, value] : words_)
            if (word == *option_)
                return value;
        return words_.front().second;
    }

  private:
    std::string word(Enum value) const
    {
        for (const auto& [word, of_word] : words_)
            if (of_word == value)
                return word;
        return {};
    }
    OneOf accepted() const
    {
        OneOf result;
        for (const auto& [word, value] : words_)
            result.words.push_back(word);
        return result;
    }

    Words words_;
    Option<std::string> option_;
};

}  // namespace fresco

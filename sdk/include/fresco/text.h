#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string_view>
#include <system_error>

/// \file Words and numbers of text files; nothing here looks at the locale.

namespace fresco
{

/// Without the blanks around it.
constexpr std::string_view trimmed(std::string_view text)
{
    constexpr std::string_view blanks = " \t\r\n";
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    return text.substr(0, text.find_last_not_of(blanks) + 1);
}

/// The words of a line.
class Words
{
  public:
    explicit Words(std::string_view line = {}) : rest_(line) {}

    /// The next word; empty at the end of the line.
    std::string_view next()
    {
        std::size_t begin = 0;
        while (begin < rest_.size() && is_blank(rest_[begin]))
            ++begin;
        std::size_t end = begin;
        while (end < rest_.size() && !is_blank(rest_[end]))
            ++end;
        const std::string_view word = rest_.substr(begin, end - begin);
        rest_.remove_prefix(end);
        return word;
    }
    std::size_t characters_left() const { return rest_.size(); }
    /// Rest of the line, without the blanks around it: a name that may hold spaces.
    std::string_view rest() const { return trimmed(rest_); }

  private:
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
    std::string_view rest_;
};

/// The number that makes up the whole word. False if it is not a number or does not fit T; "nan" and "inf" are numbers of
/// floating types.
template <class T>
bool parse_number(std::string_view word, T& value)
{
    if (word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+')
        word.remove_prefix(1);
    const char* const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    return error == std::errc{} && stop == end && !word.empty();
}

}  // namespace fresco

#include "printed_line.h"

#include <fresco/text.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace fresco::command
{
namespace
{

std::string_view take_word(std::string_view& text)
{
    const auto end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text = trimmed(text.substr(end));
    return word;
}

std::optional<double> number(std::string_view text)
{
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

std::optional<SaidToHost> progress_of(std::string_view text)
{
    const std::string_view amount = take_word(text);
    const auto slash = amount.find('/');
    const auto done = number(amount.substr(0, slash));
    if (!done || !(*done >= 0) || std::isinf(*done))
        return std::nullopt;
    if (slash == std::string_view::npos)
        return *done <= 1 ? std::optional(SaidToHost{SaidToHost::Kind::progress, 100 * *done, 100, "%", ""}) : std::nullopt;
    const auto total = number(amount.substr(slash + 1));
    if (!total || !(*total > 0) || std::isinf(*total))
        return std::nullopt;
    return SaidToHost{SaidToHost::Kind::progress, *done, *total, printable(text), ""};
}

/// How many bytes the UTF-8 character at the front has; 0 if it is invalid.
std::size_t character_length(std::string_view text)
{
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(0);
    const std::size_t length = first < 0x80                    ? 1
                               : first >= 0xC2 && first < 0xE0 ? 2
                               : first >= 0xE0 && first < 0xF0 ? 3
                               : first >= 0xF0 && first < 0xF5 ? 4
                                                               : 0;
    if (length == 0 || length > text.size())
        return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(i) & 0xC0U) != 0x80U)
            return 0;
    // Overlong forms, surrogates and numbers beyond the last character.
    const bool wrong = length > 2 && ((first == 0xE0 && byte(1) < 0xA0) || (first == 0xED && byte(1) >= 0xA0) ||
                                      (first == 0xF0 && byte(1) < 0x90) || (first == 0xF4 && byte(1) >= 0x90));
    return wrong ? 0 : length;
}

/// Removes an escape sequence from the front: ESC [ … letter, or ESC and one more.
void drop_escape(std::string_view& text)
{
    text.remove_prefix(1);
    if (text.empty())
        return;
    const bool many = text.front() == '[';
    text.remove_prefix(1);
    while (many && !text.empty())
    {
        const char c = text.front();
        text.remove_prefix(1);
        if (c >= '@' && c <= '~')
            return;
    }
}

}  // namespace

std::optional<SaidToHost> said_to_host(std::string_view line)
{
    using Kind = SaidToHost::Kind;
    constexpr std::string_view prefix = "fresco: ";
    if (!line.starts_with(prefix))
        return std::nullopt;
    std::string_view text = trimmed(line.substr(prefix.size()));
    const std::string_view verb = take_word(text);
    if (verb == "progress")
        return progress_of(text);
    if ((verb == "warning" || verb == "message") && !text.empty())
        return SaidToHost{verb == "warning" ? Kind::warning : Kind::message, 0, 0, printable(text), ""};
    if (verb != "metric" && verb != "report")
        return std::nullopt;
    const std::string_view name = take_word(text);
    if (name.empty() || text.empty())
        return std::nullopt;
    if (verb == "report")
        return SaidToHost{Kind::report, 0, 0, printable(name), std::string(text)};
    const auto value = number(text);
    return value ? std::optional(SaidToHost{Kind::metric, *value, 0, printable(name), ""}) : std::nullopt;
}

std::string printable(std::string_view line)
{
    while (!line.empty() && line.back() == '\r')
        line.remove_suffix(1);
    if (const auto start = line.rfind('\r'); start != std::string_view::npos)
        line.remove_prefix(start + 1);
    std::string result;
    while (!line.empty())
    {
        const auto first = static_cast<unsigned char>(line.front());
        if (first == 0x1B)
        {
            drop_escape(line);
            continue;
        }
        const std::size_t length = character_length(line);
        // Some terminals take U+0080 to U+009F for the beginnings of escape sequences.
        const bool control =
            first < 0x20 || first == 0x7F || (first == 0xC2 && length == 2 && static_cast<unsigned char>(line[1]) < 0xA0);
        if (length == 0)
            result += '?';
        else if (control)
            result += ' ';
        else
            result += line.substr(0, length);
        line.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return result;
}

}  // namespace fresco::command

#include "base/terminal_line.h"
#include "base/utf8.h"

#include <algorithm>
#include <fmt/format.h>

namespace fresco::host
{
namespace
{

/// Bytes of the character that begins here; 1 for invalid UTF-8.
std::size_t character_bytes(std::string_view text)
{
    const auto lead = static_cast<unsigned char>(text.front());
    const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : lead >= 0xC0 ? 2 : 1;
    return std::min(bytes, text.size());
}

/// Its number, if the character has at most three bytes; otherwise 0x1F300.
unsigned code_of(std::string_view character)
{
    const auto byte = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(character[i])); };
    switch (character.size())
    {
    case 1:
        return byte(0);
    case 2:
        return (byte(0) & 0x1FU) << 6U | (byte(1) & 0x3FU);
    case 3:
        return (byte(0) & 0x0FU) << 12U | (byte(1) & 0x3FU) << 6U | (byte(2) & 0x3FU);
    default:
        return 0x1F300U;
    }
}

/// Those of the East take two columns.
std::size_t character_columns(std::string_view character)
{
    if (character.size() < 3)
        return 1;
    const unsigned code = code_of(character);
    const bool wide = (code >= 0x1100 && code <= 0x115F) || (code >= 0x2E80 && code <= 0xA4CF) ||
                      (code >= 0xAC00 && code <= 0xD7A3) || (code >= 0xF900 && code <= 0xFAFF) ||
                      (code >= 0xFE30 && code <= 0xFE6F) || (code >= 0xFF00 && code <= 0xFF60) || code >= 0x1F300;
    return wide ? 2 : 1;
}

/// Those from U+0080 to U+009F begin escape sequences on some terminals; the later ones end a line or turn the direction of
/// writing.
bool is_control(std::string_view character)
{
    const unsigned code = code_of(character);
    return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x061C || code == 0x200E || code == 0x200F ||
           (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

const char* escape(Tone tone)
{
    switch (tone)
    {
    case Tone::good:
        return "\x1b[32m";
    case Tone::busy:
        return "\x1b[36m";
    case Tone::bad:
        return "\x1b[31m";
    default:
        return "\x1b[2m";
    }
}

}  // namespace

std::string harmless(std::string_view text, LineEnds kept)
{
    std::string result;
    for (std::size_t at = 0; at < text.size();)
    {
        const std::size_t length = utf8_length(text, at);
        const std::string_view character = text.substr(at, std::max<std::size_t>(length, 1));
        at += character.size();
        const bool continues = at < text.size() && text[at] == ' ';
        if (length == 0)
            result += fmt::format("\\x{:02x}", static_cast<unsigned char>(character.front()));
        else if (character == "\t")
            result += ' ';
        else if (character == "\n")
            result += kept == LineEnds::all || (kept == LineEnds::continued && continues) ? "\n" : "\\n";
        else if (is_control(character))
            result += code_of(character) < 0x100 ? fmt::format("\\x{:02x}", code_of(character))
                                                 : fmt::format("\\u{:04x}", code_of(character));
        else
            result += character;
    }
    return result;
}

std::size_t columns(std::string_view text)
{
    std::size_t count = 0;
    while (!text.empty())
    {
        if (text.starts_with("\x1b["))
        {
            const std::size_t end = text.find('m');
            text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
            continue;
        }
        const std::string_view character = text.substr(0, character_bytes(text));
        count += character_columns(character);
        text.remove_prefix(character.size());
    }
    return count;
}

Line& Line::add(std::string_view text, Tone tone)
{
    if (cut_)
        return *this;
    const bool colored = room_.color && tone != Tone::plain;
    if (colored)
        text_ += escape(tone);
    while (!text.empty() && !cut_)
    {
        const std::string_view character = text.substr(0, character_bytes(text));
        const std::size_t wide = character_columns(character);
        const bool last = text.size() == character.size();
        if (used_ + wide > room_.columns || (!last && used_ + wide == room_.columns))
        {
            cut_ = true;
            if (used_ < room_.columns)
                text_ += room_.utf8 ? "…" : "~";
            used_ = room_.columns;
            break;
        }
        text_ += is_control(character) ? " " : std::string(character);
        used_ += wide;
        text.remove_prefix(character.size());
    }
    if (colored)
        text_ += "\x1b[0m";
    return *this;
}

Line& Line::pad_to(std::size_t column)
{
    if (used_ < column)
        add(std::string(column - used_, ' '));
    return *this;
}

std::string Line::take()
{
    while (!text_.empty() && text_.back() == ' ')
        text_.pop_back();
    return std::move(text_);
}

}  // namespace fresco::host

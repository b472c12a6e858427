#include "base/text.h"
#include "base/common.h"

#include <algorithm>
#include <boost/algorithm/string.hpp>
#include <boost/locale/utf.hpp>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fmt/ranges.h>
#include <numeric>
#include <span>
#include <sys/ioctl.h>
#include <unistd.h>

namespace fresco::host
{

namespace
{

/// The first character of a text that is not empty; of bytes that are not UTF-8 the first, with its number.
struct Character
{
    explicit Character(std::string_view text) : bytes(text.substr(0, 1)), code(static_cast<unsigned char>(text.front()))
    {
        using Utf8 = boost::locale::utf::utf_traits<char>;
        auto next = text.begin();
        const boost::locale::utf::code_point point = Utf8::decode(next, text.end());
        is_valid = point != boost::locale::utf::illegal && point != boost::locale::utf::incomplete;
        if (is_valid)
        {
            bytes = {text.begin(), next};
            code = point;
        }
    }

    /// East Asian characters take two columns.
    std::size_t columns() const
    {
        const bool wide = (code >= 0x1100 && code <= 0x115F) || (code >= 0x2E80 && code <= 0xA4CF) ||
                          (code >= 0xAC00 && code <= 0xD7A3) || (code >= 0xF900 && code <= 0xFAFF) ||
                          (code >= 0xFE30 && code <= 0xFE6F) || (code >= 0xFF00 && code <= 0xFF60) || code >= 0x10000;
        return wide ? 2 : 1;
    }

    /// Characters from U+0080 to U+009F begin escape sequences on some terminals; the later ones end a line or turn the direction
    /// of writing.
    bool is_control() const
    {
        return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x061C || code == 0x200E || code == 0x200F ||
               (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
    }

    std::string_view bytes;
    unsigned code;
    bool is_valid = false;
};

const char* escape(Tone tone)
{
    return tone == Tone::good ? "\x1b[32m" : tone == Tone::busy ? "\x1b[36m" : tone == Tone::bad ? "\x1b[31m" : "\x1b[2m";
}

constexpr std::size_t gap = 2;
/// A folded text has at least this room beside the other columns.
constexpr std::size_t least_text = 28;
constexpr std::size_t below_indent = 4;

std::string blanks(std::size_t count)
{
    return std::string(count, ' ');
}

std::string padded(const std::string& cell, std::size_t width, bool right)
{
    const std::string space = blanks(width - std::min(width, columns(cell)));
    return right ? space + cell : cell + space;
}

/// One line, without its end.
std::string folded_line(std::string_view line, std::size_t width, std::size_t indent)
{
    const std::size_t first = std::min(line.find_first_not_of(' '), line.size());
    const std::string begin = "\n" + blanks(first + indent);
    std::string result(line.substr(0, first));
    std::size_t used = first;
    bool at_begin = true;
    for (std::size_t at = first; at < line.size();)
    {
        // A word with the blanks before it, so that columns within a line stay.
        const std::size_t word = std::min(line.find_first_not_of(' ', at), line.size());
        const std::size_t end = std::min(line.find(' ', word), line.size());
        const std::size_t wide = columns(line.substr(at, end - at));
        if (!at_begin && used + wide > width)
        {
            result += begin;
            used = begin.size() - 1;
            at = word;
        }
        result += line.substr(at, end - at);
        used += columns(line.substr(at, end - at));
        at_begin = false;
        at = end;
    }
    return result;
}

std::size_t widest_word(const std::string& text)
{
    std::vector<std::string> words;
    boost::split(words, text, boost::is_any_of(" \n"));
    return std::ranges::max(each(words, &columns));
}

}  // namespace

bool begins_character(char byte)
{
    return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
}

bool is_utf8(std::string_view text)
{
    for (std::string_view rest = text; !rest.empty(); rest.remove_prefix(Character(rest).bytes.size()))
        if (!Character(rest).is_valid)
            return false;
    return true;
}

std::optional<std::size_t> first_bad_byte(std::string_view text)
{
    for (std::string_view rest = text; !rest.empty(); rest.remove_prefix(Character(rest).bytes.size()))
        if (const Character next(rest); !next.is_valid || (next.code >= 0x7F && next.code < 0xA0) ||
                                        (next.code < 0x20 && next.bytes.find_first_of("\t\n\r") != 0))
            return text.size() - rest.size();
    return std::nullopt;
}

std::vector<std::string> split(std::string_view text, char separator)
{
    std::vector<std::string> pieces;
    boost::split(pieces, text, [&](char c) { return c == separator; });
    return pieces;
}

std::string duration_text(double seconds)
{
    if (seconds < 10)
        return fmt::format("{:.1f} s", seconds);
    const auto whole = static_cast<long>(std::lround(seconds));
    if (whole < 60)
        return fmt::format("{} s", whole);
    if (whole < 3600)
        return fmt::format("{}:{:02} min", whole / 60, whole % 60);
    return fmt::format("{}:{:02}:{:02} h", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string size_text(double megabytes)
{
    if (megabytes >= 10'240)
        return fmt::format("{:.1f} GB", megabytes / 1024);
    return megabytes >= 10 ? fmt::format("{:.0f} MB", megabytes) : fmt::format("{:.1f} MB", megabytes);
}

std::string counted(std::size_t count, std::string_view noun)
{
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string path_text(const std::filesystem::path& path)
{
    std::error_code error;
    const std::filesystem::path here = path.lexically_relative(std::filesystem::current_path(error));
    return here.empty() || *here.begin() == ".." ? path.string() : here.string();
}

std::string shell_word(const std::string& text)
{
    const auto is_plain = [](char c)
    { return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("_./+-,@=", c) != nullptr; };
    if (!text.empty() && std::ranges::all_of(text, is_plain))
        return text;
    return "'" + boost::replace_all_copy(text, "'", "'\\''") + "'";
}

std::string harmless(std::string_view text, LineEnds kept)
{
    std::string result;
    while (!text.empty())
    {
        const Character character(text);
        text.remove_prefix(character.bytes.size());
        const bool continues = text.starts_with(' ');
        if (!character.is_valid)
            result += fmt::format("\\x{:02x}", character.code);
        else if (character.bytes == "\t")
            result += ' ';
        else if (character.bytes == "\n")
            result += kept == LineEnds::all || (kept == LineEnds::continued && continues) ? "\n" : "\\n";
        else if (character.is_control())
            result +=
                character.code < 0x100 ? fmt::format("\\x{:02x}", character.code) : fmt::format("\\u{:04x}", character.code);
        else
            result += character.bytes;
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
        const Character character(text);
        count += character.columns();
        text.remove_prefix(character.bytes.size());
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
        const Character character(text);
        const std::size_t wide = character.columns();
        const bool last = text.size() == character.bytes.size();
        if (used_ + wide > room_.columns || (!last && used_ + wide == room_.columns))
        {
            cut_ = true;
            if (used_ < room_.columns)
                text_ += room_.utf8 ? "…" : "~";
            used_ = room_.columns;
            break;
        }
        text_ += character.is_control() ? " " : character.bytes;
        used_ += wide;
        text.remove_prefix(character.bytes.size());
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
    return boost::trim_right_copy_if(text_, boost::is_any_of(" "));
}

std::size_t terminal_width(int descriptor)
{
    if (const char* variable = std::getenv("COLUMNS"))
    {
        std::size_t width = 0;
        const std::string_view text = variable;
        if (std::from_chars(text.data(), text.data() + text.size(), width).ec == std::errc() && width > 0)
            return width;
    }
    winsize size{};
    return ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : without_end;
}

std::string folded(std::string_view text, std::size_t width, std::size_t indent)
{
    const auto fold = [&](const std::string& line) { return columns(line) > width ? folded_line(line, width, indent) : line; };
    return fmt::format("{}", fmt::join(each(split(text, '\n'), fold), "\n"));
}

void print_message(std::string_view text)
{
    // A log is searched line by line.
    const std::size_t width = isatty(STDERR_FILENO) != 0 ? terminal_width(STDERR_FILENO) : without_end;
    std::fputs((folded(harmless(text, LineEnds::continued), width, below_indent) + "\n").c_str(), stderr);
    std::fflush(stderr);
}

void print_line(std::string_view text)
{
    std::fputs((harmless(text, LineEnds::none) + "\n").c_str(), stdout);
}

std::string shortened(std::string_view name, std::size_t width)
{
    if (columns(name) <= width)
        return std::string(name);
    std::vector<std::string_view> characters;
    for (std::string_view rest = name; !rest.empty(); rest.remove_prefix(characters.back().size()))
        characters.push_back(Character(rest).bytes);
    std::size_t left = 0;
    std::size_t right = characters.size();
    std::size_t room = width - 1;
    for (bool at_begin = true; columns(characters[at_begin ? left : right - 1]) <= room; at_begin = !at_begin)
        room -= columns(characters[at_begin ? left++ : --right]);
    return fmt::format("{}…{}", fmt::join(std::span(characters).first(left), ""),
                       fmt::join(std::span(characters).subspan(right), ""));
}

void TextTable::add(std::vector<std::string> row)
{
    for (std::string& cell : row)
        cell = harmless(cell, LineEnds::none);
    rows_.push_back(std::move(row));
}

std::string TextTable::text(std::size_t width) const
{
    std::vector<std::size_t> widths;
    for (std::size_t i = 0; i < columns_.size(); ++i)
    {
        widths.push_back(columns(columns_[i].title));
        for (const auto& row : rows_)
            widths[i] = std::max(widths[i], columns(row[i]));
    }
    const std::size_t all = std::accumulate(widths.begin(), widths.end(), indent_ + gap * (widths.size() - 1));
    const std::size_t fixed = all - widths.back();
    // One text at most can be folded beside the others.
    if (const bool has_text = columns_.back().kind == Kind::text; all <= width || (has_text && fixed + least_text <= width))
        return in_columns(widths, has_text ? fixed : 0, all <= width ? without_end : width);
    return in_columns(widths, 0, width);
}

/// `text_at`: where the last column, a text, begins; 0: texts go below.
std::string TextTable::in_columns(const std::vector<std::size_t>& widths, std::size_t text_at, std::size_t width) const
{
    std::string result;
    const auto add = [&](const std::vector<std::string>& row, bool is_title)
    {
        std::string line = blanks(indent_);
        std::string below;
        for (std::size_t i = 0; i < row.size(); ++i)
        {
            const Column& column = columns_[i];
            const std::size_t here = width - text_at;
            // A path may be wider than its column but not than the terminal.
            if (column.kind == Kind::text && (text_at == 0 || widest_word(row[i]) > here))
            {
                if (!is_title && !row[i].empty())
                    below += folded(blanks(indent_ + below_indent) + row[i], width) + "\n";
                continue;
            }
            const bool last = i + 1 == row.size();
            line += blanks(i > 0 ? gap : 0);
            if (column.kind == Kind::text && last)
                line += boost::replace_all_copy(folded(row[i], here), "\n", "\n" + blanks(text_at));
            else
                line += padded(row[i], widths[i], column.kind == Kind::number);
        }
        result += boost::trim_right_copy_if(line, boost::is_any_of(" ")) + "\n" + below;
    };
    if (!std::ranges::all_of(columns_, &std::string::empty, &Column::title))
        add(each(columns_, &Column::title), true);
    for (const auto& row : rows_)
        add(row, false);
    return result;
}

}  // namespace fresco::host

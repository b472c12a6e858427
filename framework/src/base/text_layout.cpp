#include "base/text_layout.h"
#include "base/terminal_line.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <sys/ioctl.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

constexpr std::size_t gap = 2;
/// A folded text has at least this room beside the other columns.
constexpr std::size_t least_text = 28;
constexpr std::size_t least_name = 12;
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

/// As one word, for folded().
std::string tied(std::string text)
{
    std::ranges::replace(text, ' ', '\x1f');
    return text;
}

std::string untied(std::string text)
{
    std::ranges::replace(text, '\x1f', ' ');
    return text;
}

std::string without_end_blanks(std::string line)
{
    line.erase(line.find_last_not_of(' ') + 1);
    return line;
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

std::size_t widest_word(std::string_view text)
{
    std::size_t widest = 0;
    for (std::size_t at = 0; at < text.size();)
    {
        const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
        widest = std::max(widest, columns(text.substr(at, end - at)));
        at = end + 1;
    }
    return widest;
}

}  // namespace

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
    std::string result;
    while (!text.empty())
    {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        result += columns(line) > width ? folded_line(line, width, indent) : std::string(line);
        result += end < text.size() ? "\n" : "";
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return result;
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
    // Bytes at which characters begin, and the end.
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < name.size(); ++i)
        if ((static_cast<unsigned char>(name[i]) & 0xC0U) != 0x80U)
            begins.push_back(i);
    std::string head;
    std::string tail;
    std::size_t left = 0;
    std::size_t right = begins.size();
    const auto character = [&](std::size_t i)
    { return name.substr(begins[i], (i + 1 < begins.size() ? begins[i + 1] : name.size()) - begins[i]); };
    while (left < right)
    {
        const bool from_head = columns(head) <= columns(tail);
        const std::string_view next = character(from_head ? left : right - 1);
        if (columns(head) + columns(tail) + columns(next) + 1 > width)
            break;
        if (from_head)
            head += character(left++);
        else
            tail.insert(0, character(--right));
    }
    return head + "…" + tail;
}

void TextTable::add(std::vector<std::string> row)
{
    for (std::string& cell : row)
        cell = harmless(cell, LineEnds::none);
    rows_.push_back(std::move(row));
}

bool TextTable::has_titles() const
{
    return std::ranges::any_of(columns_, [](const Column& column) { return !column.title.empty(); });
}

std::vector<std::size_t> TextTable::natural_widths() const
{
    std::vector<std::size_t> widths;
    for (std::size_t i = 0; i < columns_.size(); ++i)
    {
        widths.push_back(columns(columns_[i].title));
        for (const auto& row : rows_)
            widths[i] = std::max(widths[i], columns(row[i]));
    }
    return widths;
}

std::string TextTable::text(std::size_t width) const
{
    std::vector<std::size_t> widths = natural_widths();
    const auto is_text = [&](std::size_t i) { return columns_[i].kind == Kind::text; };
    const auto room = [&](bool with_texts)
    {
        std::size_t sum = indent_;
        for (std::size_t i = 0; i < widths.size(); ++i)
            sum += is_text(i) && !with_texts ? 0 : widths[i] + (i > 0 ? gap : 0);
        return sum;
    };
    const std::size_t texts = static_cast<std::size_t>(std::ranges::count(columns_, Kind::text, &Column::kind));
    if (width == without_end || room(true) <= width)
        return in_columns(widths, texts > 0 ? room(true) - widths.back() : 0, without_end);
    // One text at most can be folded beside the others.
    if (const std::size_t fixed = room(true) - widths.back(); texts > 0 && fixed + least_text <= width)
        return in_columns(widths, fixed, width);
    while (room(false) > width)
    {
        std::size_t widest = widths.size();
        for (std::size_t i = 0; i < widths.size(); ++i)
            if (columns_[i].kind == Kind::name && widths[i] > least_name &&
                (widest == widths.size() || widths[i] > widths[widest]))
                widest = i;
        if (widest == widths.size())
            return stacked(width);
        --widths[widest];
    }
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
            const std::size_t here = width == without_end ? without_end : width - text_at;
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
            {
                std::string text = folded(row[i], here);
                for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 1))
                    text.insert(at + 1, blanks(text_at));
                line += text;
            }
            else
                line += padded(column.kind == Kind::name ? shortened(row[i], widths[i]) : row[i], widths[i],
                               column.kind == Kind::number);
        }
        result += without_end_blanks(std::move(line)) + "\n" + below;
    };
    if (has_titles())
    {
        std::vector<std::string> titles;
        for (const Column& column : columns_)
            titles.push_back(column.title);
        add(titles, true);
    }
    for (const auto& row : rows_)
        add(row, false);
    return result;
}

std::string TextTable::stacked(std::size_t width) const
{
    std::string result;
    for (const auto& row : rows_)
    {
        std::string head;
        std::string figures;
        std::string texts;
        const std::string begin = blanks(indent_ + below_indent);
        const std::size_t room = std::max(least_name, width - std::min(width, indent_));
        for (std::size_t i = 0; i < row.size(); ++i)
        {
            const Column& column = columns_[i];
            if (row[i].empty())
                continue;
            if (column.kind == Kind::name || i == 0)
                head += (head.empty() ? blanks(indent_) : blanks(gap)) + shortened(row[i], room);
            else if (column.kind == Kind::text)
                texts += folded(begin + row[i], width) + "\n";
            else
                figures += (figures.empty() ? begin : ", ") + tied((column.title.empty() ? "" : column.title + " ") + row[i]);
        }
        result += folded(head, width, below_indent) + "\n";
        result += figures.empty() ? "" : untied(folded(figures, width)) + "\n";
        result += texts;
    }
    return result;
}

}  // namespace fresco::host

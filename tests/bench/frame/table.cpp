#include "table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace bench
{
namespace
{

std::string fixed(double number, int digits)
{
    std::array<char, 400> text{};
    // Small and not zero: the digits that count.
    const bool small = number != 0 && std::abs(number) < 0.5 * std::pow(10, -digits);
    const auto end = small ? std::to_chars(text.begin(), text.end(), number, std::chars_format::scientific, 1)
                           : std::to_chars(text.begin(), text.end(), number, std::chars_format::fixed, digits);
    return {text.data(), end.ptr};
}

/// Of UTF-8: code points.
std::size_t width(const std::string& text)
{
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t to, bool left)
{
    const std::string gap(to - std::min(to, width(text)), ' ');
    return left ? text + gap : gap + text;
}

}  // namespace

fresco::Value figure(double number)
{
    return std::isfinite(number) ? fresco::Value(number) : fresco::Value();
}

fresco::Value entry(const fresco::Value& row, const std::string& key)
{
    const auto* found = row.find(key);
    return found != nullptr ? *found : fresco::Value();
}

fresco::Value ratio(const fresco::Value& more, const fresco::Value& less)
{
    if (!more.is_number() || !less.is_number() || !(more.as_double() > 0) || !(less.as_double() > 0))
        return {};
    return more.as_double() / less.as_double();
}

Table::Table(std::string name, std::string caption, std::vector<Column> columns)
    : name_(std::move(name)), caption_(std::move(caption)), columns_(std::move(columns))
{
}

void Table::add(fresco::Value row)
{
    rows_.push_back(std::move(row));
}

std::string Table::cell(const fresco::Value& row, const Column& column) const
{
    const auto value = entry(row, column.key);
    if (value.is_string())
        return value.as_string();
    if (value.is_int())
        return std::to_string(value.as_int());
    if (value.is_number())
        return fixed(value.as_double(), column.digits);
    return "-";
}

std::string Table::text() const
{
    std::vector<std::vector<std::string>> lines(1);
    for (const auto& column : columns_)
        lines[0].push_back(column.title);
    for (const auto& row : rows_)
    {
        lines.emplace_back();
        for (const auto& column : columns_)
            lines.back().push_back(cell(row, column));
    }
    std::string out = "\n" + name_ + ": " + caption_ + "\n";
    for (const auto& line : lines)
    {
        std::string text;
        for (std::size_t c = 0; c < columns_.size(); ++c)
        {
            std::size_t widest = 0;
            for (const auto& other : lines)
                widest = std::max(widest, width(other[c]));
            const bool words =
                std::any_of(rows_.begin(), rows_.end(), [&](const auto& row) { return entry(row, columns_[c].key).is_string(); });
            text += "  " + padded(line[c], widest, words);
        }
        text.erase(text.find_last_not_of(' ') + 1);
        out += text + "\n";
    }
    // Why a row is missing figures.
    for (const auto& row : rows_)
        if (const auto note = entry(row, "note"); note.is_string())
            out += "  * " + cell(row, columns_.front()) + ": " + note.as_string() + "\n";
    return out;
}

}  // namespace bench

#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// \file Texts and tables in the width of a terminal. Widths are in columns; without_end is that of a file or a pipe.

namespace fresco::host
{

inline constexpr std::size_t without_end = std::string::npos;

/// Of the terminal behind a descriptor, or what COLUMNS says where that is set.
std::size_t terminal_width(int descriptor);

/// Breaks lines that are wider than `width` at blanks, never within a word: one that is wider stands out. What was broken goes on
/// behind `indent` blanks more than its line begins with.
std::string folded(std::string_view text, std::size_t width, std::size_t indent = 0);

/// A message to standard error, with an end of line: harmless, and in the width of the terminal if it is one.
void print_message(std::string_view text);

/// A line to standard output, about a name: harmless, never folded.
void print_line(std::string_view text);

/// A name with "…" in place of its middle where it is wider than `width`, which is at least 3.
std::string shortened(std::string_view name, std::size_t width);

/// Rows in columns. Where the terminal is too narrow, texts are folded, then go below their rows; then names are shortened, down
/// to a dozen columns. Where that is not enough, a row takes several lines: what it begins with and its other names, then its
/// figures with their titles.
class TextTable
{
  public:
    enum class Kind
    {
        name,
        figure,  ///< Aligned to the left.
        number,  ///< To the right.
        text     ///< Behind all others.
    };
    struct Column
    {
        std::string title;  ///< No column has one: no line of titles.
        Kind kind = Kind::figure;
    };

    explicit TextTable(std::vector<Column> columns, std::size_t indent = 0) : columns_(std::move(columns)), indent_(indent) {}

    void add(std::vector<std::string> row);
    /// All lines.
    std::string text(std::size_t width) const;

  private:
    bool has_titles() const;
    std::vector<std::size_t> natural_widths() const;
    std::string in_columns(const std::vector<std::size_t>& widths, std::size_t text_at, std::size_t width) const;
    std::string stacked(std::size_t width) const;

    std::vector<Column> columns_;
    std::size_t indent_;
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace fresco::host

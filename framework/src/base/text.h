#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file Text for people: sizes and times in words, names that cannot move a cursor, lines and tables in the width of a
/// terminal. Widths are in columns; without_end is that of a file or a pipe.

namespace fresco::host
{

/// Whether a byte of a text in UTF-8 is the first of its character.
bool begins_character(char byte);
bool is_utf8(std::string_view text);
/// Offset of the first byte that is not UTF-8, or control character (U+0000 to U+001F, U+007F to U+009F), which cut paths and
/// move cursors; tabulators and line ends are for the caller to allow.
std::optional<std::size_t> first_bad_byte(std::string_view text);

/// The pieces between separators, empty ones too.
std::vector<std::string> split(std::string_view text, char separator);

/// "1:02:03", "2:03", "41 s".
std::string duration_text(double seconds);
/// "12.3 s", "350 MB": for tables.
std::string size_text(double megabytes);
/// "1 task", "2 tasks".
std::string counted(std::size_t count, std::string_view noun);
/// Relative to the working directory where it is below that.
std::string path_text(const std::filesystem::path& path);
/// As a shell reads it back.
std::string shell_word(const std::string& text);

/// Ends of lines that harmless() keeps.
enum class LineEnds
{
    all,        ///< Line ends of a log.
    continued,  ///< Line ends of a message before an indented line. A name can begin no line that passes for another message.
    none        ///< A name keeps none.
};

/// A text to show to people. Control characters, by which a file's name could move the cursor, and those that turn the direction
/// of writing are escaped, such as "\x1b" and "\u202e", and so are bytes that are not UTF-8; a tabulator is a blank.
std::string harmless(std::string_view text, LineEnds kept);

/// Columns that a text in UTF-8 takes on a terminal, escape sequences for colors left out.
std::size_t columns(std::string_view text);

enum class Tone
{
    plain,
    good,
    busy,
    bad,
    faint
};

struct LineRoom
{
    std::size_t columns = 79;
    bool utf8 = true;
    bool color = false;
};

/// A line of text that is cut where the room ends, with an ellipsis. Control characters become blanks.
class Line
{
  public:
    explicit Line(const LineRoom& room) : room_(room) {}

    Line& add(std::string_view text, Tone tone = Tone::plain);
    /// Blanks up to a column.
    Line& pad_to(std::size_t column);
    /// The text without blanks at its end.
    std::string take();

  private:
    std::string text_;
    std::size_t used_ = 0;
    bool cut_ = false;
    LineRoom room_;
};

inline constexpr std::size_t without_end = std::string::npos;

/// Width of the terminal behind a descriptor, or COLUMNS if that is set.
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

/// Rows in columns. Where the terminal is too narrow, texts are folded, then go below their rows.
class TextTable
{
  public:
    enum class Kind
    {
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
    std::string in_columns(const std::vector<std::size_t>& widths, std::size_t text_at, std::size_t width) const;

    std::vector<Column> columns_;
    std::size_t indent_;
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace fresco::host

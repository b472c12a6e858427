#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fresco::host
{

/// Ends of lines that harmless() keeps.
enum class LineEnds
{
    all,        ///< Of a log.
    continued,  ///< Of a message: those before an indented line. A name can begin no line that passes for another message.
    none        ///< Of a name.
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

}  // namespace fresco::host

#pragma once

#include <fresco/math.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file Strict reading of the small text tables that recorders write, a record per line.
namespace fresco::recordings
{

/// Walks the lines of a text. The text must outlive it.
class LineReader
{
  public:
    /// Throws Error naming `source` if the text does not end in a line's end: then it is taken as cut.
    LineReader(std::string_view text, std::string_view source);
    /// The next line without its end; nothing after the last one.
    std::optional<std::string_view> next();
    /// The next line that is not blank and does not begin with '#'.
    std::optional<std::string_view> next_record();
    /// "source:line" of the line that was read last.
    std::string place() const;

  private:
    std::string_view rest_;
    std::string source_;
    std::size_t line_ = 0;
};

/// The words of a line, separated by one or more of these characters.
std::vector<std::string_view> words_of(std::string_view line, std::string_view separators = " \t\r");
/// A finite number, in any locale. Throws Error naming `place`.
double number_of(std::string_view word, const std::string& place);
/// A whole number from `least` to `most`. Throws Error naming `place`.
std::int64_t integer_of(std::string_view word, std::int64_t least, std::int64_t most, const std::string& place);

/// The rotation of the quaternion w + xi + yj + zk, and a translation. Throws Error naming `place` unless all are finite and the
/// length is 1 within 0.01; it is made 1.
RigidTransform quaternion_transform(double w, double x, double y, double z, Vec3d translation, const std::string& place);

/// Whether `a` goes before `b` where runs of digits count as numbers: "frame9" before "frame10". A total order.
bool natural_less(std::string_view a, std::string_view b);
/// The number of "seq-01" behind the prefix "seq-"; nothing if `text` is not the prefix and digits.
std::optional<long> number_after(std::string_view text, std::string_view prefix);
/// The last run of digits of a text, such as 12 of "frame_0012"; nothing without one or beyond 18 digits.
std::optional<long> last_number(std::string_view text);

}  // namespace fresco::recordings

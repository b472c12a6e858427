#pragma once

#include <fresco/camera.h>
#include <fresco/math.h>
#include <fresco/value.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

/// \file Strict parsing of what recorders write: text tables, matrices, JSON, binary files. Every error names its place.

namespace fresco::recordings
{

/// Treatment by a LineReader of a text that does not end in a line's end.
enum class LastLine
{
    ended,  ///< It is taken as cut.
    any
};

/// Walks the lines of a text. The text must outlive it.
class LineReader
{
  public:
    /// Throws Error naming `source` if the last line is not as `last` wants it.
    LineReader(std::string_view text, std::string_view source, LastLine last = LastLine::ended);
    /// The next line without its end; nothing after the last one.
    std::optional<std::string_view> next();
    /// The next line that is not blank and does not begin with '#'.
    std::optional<std::string_view> next_record();
    /// "source:line" of the line that was read last.
    std::string place() const;
    /// Its number, from 1.
    std::size_t line() const { return line_; }

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

/// Strict reader of a rows x columns matrix: one row per line, numbers separated by blanks or tabs, in any locale; blank lines
/// are skipped. `nan` and `inf` are numbers here, the caller judges them. Throws Error "source:line: …" on anything that is no
/// number, a row of another length, too few or too many rows. Returns row-major values.
std::vector<double> parse_matrix_text(std::string_view text, int rows, int columns, std::string_view source);
/// Reads a matrix from a file. Throws MissingInput if it cannot be read.
std::vector<double> read_matrix_text(const std::filesystem::path& file, int rows, int columns);

/// As parse_json, but NaN and Infinity, which Python writes, are null.
Value parse_recorded_json(std::string_view text, std::string_view source);

/// Row-major numbers separated by blanks on one line, exactly `count` of them. Throws Error naming `source`.
std::vector<double> parse_numbers(std::string_view text, std::size_t count, std::string_view source);

/// The rigid transform of a row-major 4x4 matrix. Throws Error naming `source` if an entry is not finite, the last row is not
/// 0 0 0 1 or the upper left part is no rotation (rotation_error > 1e-2, or a mirror). Written with few digits it is almost one:
/// the nearest rotation is taken.
RigidTransform rigid_transform(const std::vector<double>& matrix, std::string_view source);
RigidTransform read_rigid_transform(const std::filesystem::path& file);

/// Coordinates of the first pixel's center in a calibration.
enum class PixelCenter
{
    half,    ///< At (0.5, 0.5), as fresco does: cx = width / 2 is the middle.
    integer  ///< At (0, 0), as OpenCV's calibration does: cx = (width - 1) / 2 is the middle, and 0.5 is added.
};

/// Intrinsics of a row-major 3x3 or 4x4 matrix (fx 0 cx / 0 fy cy / 0 0 1). Throws Error naming `source` for skew, focal lengths
/// that are not positive, entries that are not finite, or anything else in the places of 0 and 1.
Intrinsics intrinsics_from_matrix(const std::vector<double>& matrix, PixelCenter center, int width, int height,
                                  std::string_view source);

/// Reads little-endian numbers from a file's bytes, never beyond their end. The bytes must outlive it.
class ByteCursor
{
  public:
    ByteCursor(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source) {}

    std::size_t offset() const { return offset_; }
    std::size_t left() const { return bytes_.size() - offset_; }
    /// "source: byte offset" of what comes next.
    std::string place() const;

    /// Throws Error naming place and `what` if the file ends before.
    template <class T>
    T read(std::string_view what)
    {
        static_assert(std::is_arithmetic_v<T> && std::endian::native == std::endian::little);
        T value;
        std::memcpy(&value, take(sizeof value, what).data(), sizeof value);
        return value;
    }
    std::span<const std::byte> take(std::uint64_t count, std::string_view what);
    /// Text up to a zero byte, which is passed.
    std::string_view text(std::string_view what);
    /// Throws Error if something is left.
    void expect_end() const;

  private:
    std::span<const std::byte> bytes_;
    std::string source_;
    std::size_t offset_ = 0;
};

}  // namespace fresco::recordings

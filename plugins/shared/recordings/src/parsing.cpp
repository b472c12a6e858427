#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/numerics/numerics.h>
#include <fresco/recordings/parsing.h>
#include <fresco/text.h>
#include <fresco/value.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <string>

namespace fresco::recordings
{

namespace
{

constexpr std::size_t shown_word = 40;
constexpr std::size_t most_digits = 18;  // As many as fit into a long.
constexpr std::string_view blanks = " \t\r";

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

std::string shown(std::string_view word)
{
    return "\"" + std::string(word.substr(0, shown_word)) + "\"";
}

/// With four decimals at most, in any locale.
std::string number_text(double number)
{
    constexpr double decimals = 1e4;
    return to_json(std::round(number * decimals) / decimals);
}

/// The length of the run of digits at the front.
std::size_t digits_at(std::string_view text)
{
    return static_cast<std::size_t>(std::ranges::find_if_not(text, is_digit) - text.begin());
}

}  // namespace

LineReader::LineReader(std::string_view text, std::string_view source, LastLine last) : rest_(text), source_(source)
{
    if (last == LastLine::ended && !text.ends_with('\n'))
        throw Error(
            source_ +
            ": the last line has no newline: the file may be truncated; copy it again (if it is complete, add a final newline)");
}

std::optional<std::string_view> LineReader::next()
{
    if (rest_.empty())
        return std::nullopt;
    auto line = rest_.substr(0, rest_.find('\n'));
    rest_.remove_prefix(std::min(line.size() + 1, rest_.size()));
    ++line_;
    if (line.ends_with('\r'))
        line.remove_suffix(1);
    return line;
}

std::optional<std::string_view> LineReader::next_record()
{
    while (const auto line = next())
        if (const auto first = line->find_first_not_of(blanks); first != std::string_view::npos && (*line)[first] != '#')
            return line;
    return std::nullopt;
}

std::string LineReader::place() const
{
    return fmt::format("{}:{}", source_, line_);
}

std::vector<std::string_view> words_of(std::string_view line, std::string_view separators)
{
    std::vector<std::string_view> words;
    while (true)
    {
        const auto begin = line.find_first_not_of(separators);
        if (begin == std::string_view::npos)
            return words;
        const auto end = std::min(line.find_first_of(separators, begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        line.remove_prefix(end);
    }
}

double number_of(std::string_view word, const std::string& place)
{
    double number = 0;
    if (!parse_number(word, number) || !std::isfinite(number))
        throw Error(place + ": " + shown(word) + ": expected a finite number");
    return number;
}

std::int64_t integer_of(std::string_view word, std::int64_t least, std::int64_t most, const std::string& place)
{
    std::int64_t number = 0;
    if (!parse_number(word, number) || number < least || number > most)
        throw Error(fmt::format("{}: {}: expected a whole number from {} to {}", place, shown(word), least, most));
    return number;
}

RigidTransform quaternion_transform(double w, double x, double y, double z, Vec3d translation, const std::string& place)
{
    const double norm = std::sqrt(w * w + x * x + y * y + z * z);
    if (!(std::abs(norm - 1) <= 0.01))
        throw Error(place + ": expected a rotation, a quaternion of length 1; its length is " +
                    (std::isfinite(norm) ? number_text(norm) : "none") + "; check the order of the columns");
    if (!std::isfinite(translation.x) || !std::isfinite(translation.y) || !std::isfinite(translation.z))
        throw Error(place + ": the translation is not finite");
    return {numerics::rotation_of(w / norm, x / norm, y / norm, z / norm), translation};
}

bool natural_less(std::string_view a, std::string_view b)
{
    const std::string_view all_a = a, all_b = b;
    while (!a.empty() && !b.empty())
    {
        if (is_digit(a.front()) && is_digit(b.front()))
        {
            const auto significant = [](std::string_view run)
            { return run.substr(std::min(run.find_first_not_of('0'), run.size())); };
            const auto length_a = digits_at(a), length_b = digits_at(b);
            const auto number_a = significant(a.substr(0, length_a)), number_b = significant(b.substr(0, length_b));
            if (number_a.size() != number_b.size())
                return number_a.size() < number_b.size();
            if (number_a != number_b)
                return number_a < number_b;
            a.remove_prefix(length_a);
            b.remove_prefix(length_b);
            continue;
        }
        if (a.front() != b.front())
            return a.front() < b.front();
        a.remove_prefix(1);
        b.remove_prefix(1);
    }
    if (a.empty() != b.empty())
        return a.empty();
    // "01" and "1" are the same number: the texts decide.
    return all_a < all_b;
}

std::optional<long> number_after(std::string_view text, std::string_view prefix)
{
    if (!text.starts_with(prefix))
        return std::nullopt;
    const auto digits = text.substr(prefix.size());
    if (digits.empty() || digits_at(digits) != digits.size())
        return std::nullopt;
    return last_number(digits);
}

std::optional<long> last_number(std::string_view text)
{
    const auto last = std::find_if(text.rbegin(), text.rend(), is_digit);
    const auto end = static_cast<std::size_t>(text.rend() - last);
    const auto first = std::find_if_not(last, text.rend(), is_digit);
    const auto begin = static_cast<std::size_t>(text.rend() - first);
    if (begin == end || end - begin > most_digits)
        return std::nullopt;
    long number = 0;
    std::from_chars(text.data() + begin, text.data() + end, number);
    return number;
}

namespace
{

constexpr std::size_t matrix_file_limit = 1U << 20U;
constexpr double exactness = 1e-6;
constexpr double rotation_tolerance = 1e-2;

std::vector<double> parse_row(std::string_view line, const std::string& place)
{
    std::vector<double> row;
    for (const auto word : words_of(line))
        if (!parse_number(word, row.emplace_back()))
            throw Error(place + ": " + shown(word) + " is not a number");
    return row;
}

}  // namespace

std::vector<double> parse_matrix_text(std::string_view text, int rows, int columns, std::string_view source)
{
    const std::string shape = fmt::format("{}x{}", rows, columns);
    std::vector<double> values;
    int rows_read = 0;
    LineReader lines(text, source, LastLine::any);
    while (const auto line = lines.next())
    {
        const std::string place = lines.place();
        const auto row = parse_row(*line, place);
        if (row.empty())
            continue;
        if (rows_read == rows)
            throw Error(place + ": expected a " + shape + " matrix, but found another row");
        if (row.size() != static_cast<std::size_t>(columns))
            throw Error(fmt::format("{}: {} numbers; a row of a {} matrix has {}", place, row.size(), shape, columns));
        values.insert(values.end(), row.begin(), row.end());
        ++rows_read;
    }
    if (rows_read != rows)
        throw Error(fmt::format("{}: {} rows; expected a {} matrix", source, rows_read, shape));
    return values;
}

std::vector<double> read_matrix_text(const std::filesystem::path& file, int rows, int columns)
{
    return parse_matrix_text(read_text_file(file, matrix_file_limit), rows, columns, file.string());
}

Value parse_recorded_json(std::string_view text, std::string_view source)
{
    std::string plain;
    bool is_text = false;
    for (std::size_t i = 0; i < text.size(); ++i)
    {
        if (text[i] == '"')
            is_text = !is_text;
        if (is_text && text[i] == '\\' && i + 1 < text.size())
            plain += text[i++];
        std::size_t length = 0;
        for (const std::string_view word : {"NaN", "-NaN", "Infinity", "-Infinity"})
            if (!is_text && text.substr(i).starts_with(word))
                length = word.size();
        if (length > 0)
            plain += "null";
        else
            plain += text[i];
        i += length > 0 ? length - 1 : 0;
    }
    return parse_json(plain, source);
}

std::vector<double> parse_numbers(std::string_view text, std::size_t count, std::string_view source)
{
    auto values = parse_row(text, std::string(source));
    if (values.size() != count)
        throw Error(fmt::format("{}: {} numbers; expected {}", source, values.size(), count));
    return values;
}

namespace
{

/// The rotation nearest to a matrix that almost is one: Newton's iteration for the polar decomposition, R = (3 R - R RᵀR) / 2.
Mat3 nearest_rotation(Mat3 r)
{
    for (int step = 0; step < 5; ++step)
    {
        const Mat3 cubed = r * (transposed(r) * r);
        for (std::size_t i = 0; i < r.m.size(); ++i)
            r.m[i] = 1.5 * r.m[i] - 0.5 * cubed.m[i];
    }
    return r;
}

}  // namespace

RigidTransform rigid_transform(const std::vector<double>& matrix, std::string_view source)
{
    const std::string name(source);
    if (matrix.size() != 16)
        throw Error(fmt::format("{}: {} numbers; expected a 4x4 matrix", name, matrix.size()));
    if (!std::ranges::all_of(matrix, [](double entry) { return std::isfinite(entry); }))
        throw Error(name + ": the transform has an entry that is not finite; leave this frame out");
    for (std::size_t i = 12; i < 16; ++i)
        if (std::abs(matrix[i] - (i == 15 ? 1.0 : 0.0)) > exactness)
            throw Error(name + ": expected 0 0 0 1 as the last row of a rigid transform" +
                        (matrix[3] == 0 && matrix[7] == 0 && matrix[11] == 0
                             ? ", and it is the last column: write the matrix row by row"
                             : ""));
    RigidTransform transform;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            transform.rotation(row, column) = matrix[static_cast<std::size_t>(row * 4 + column)];
    transform.translation = {matrix[3], matrix[7], matrix[11]};
    if (const double error = transform.rotation_error(); !(error <= rotation_tolerance))
        throw Error(name + ": the upper left 3x3 part is not a rotation (" +
                    (std::isinf(error) ? "it mirrors" : "it is off by " + number_text(error)) +
                    "); expected a rigid transform, row by row, without scale or mirror");
    transform.rotation = nearest_rotation(transform.rotation);
    return transform;
}

RigidTransform read_rigid_transform(const std::filesystem::path& file)
{
    return rigid_transform(read_matrix_text(file, 4, 4), file.string());
}

Intrinsics intrinsics_from_matrix(const std::vector<double>& matrix, PixelCenter center, int width, int height,
                                  std::string_view source)
{
    const std::string name(source);
    const std::size_t size = matrix.size() == 16 ? 4 : 3;
    if (matrix.size() != size * size)
        throw Error(fmt::format("{}: {} numbers; expected a 3x3 or 4x4 matrix of intrinsics", name, matrix.size()));
    for (std::size_t row = 0; row < size; ++row)
        for (std::size_t column = 0; column < size; ++column)
        {
            const double entry = matrix[row * size + column];
            if (!std::isfinite(entry))
                throw Error(name + ": the intrinsics have an entry that is not finite");
            const bool is_free = (row < 2 && column == row) || (row < 2 && column == 2);
            if (!is_free && std::abs(entry - (row == column ? 1.0 : 0.0)) > exactness)
                throw Error(fmt::format("{}: intrinsics are fx 0 cx / 0 fy cy / 0 0 1 (no skew), but row {}, column {} is {}",
                                        name, row + 1, column + 1, number_text(entry)));
        }
    const double shift = center == PixelCenter::integer ? 0.5 : 0.0;
    const Intrinsics intrinsics{.width = width,
                                .height = height,
                                .fx = matrix[0],
                                .fy = matrix[size + 1],
                                .cx = matrix[2] + shift,
                                .cy = matrix[size + 2] + shift};
    if (!(intrinsics.fx > 0 && intrinsics.fy > 0))
        throw Error(name + ": the focal lengths must be positive, in pixels");
    return intrinsics;
}

std::string ByteCursor::place() const
{
    return fmt::format("{}: byte {}", source_, offset_);
}

std::span<const std::byte> ByteCursor::take(std::uint64_t count, std::string_view what)
{
    if (count > left())
        throw Error(fmt::format("{}: the file ends inside {} ({} bytes, {} remain): it is truncated or damaged; copy it again",
                                place(), what, count, left()));
    const auto part = bytes_.subspan(offset_, static_cast<std::size_t>(count));
    offset_ += part.size();
    return part;
}

std::string_view ByteCursor::text(std::string_view what)
{
    const auto rest = bytes_.subspan(offset_);
    const auto end = std::find(rest.begin(), rest.end(), std::byte{0});
    if (end == rest.end())
        throw Error(place() + ": the file ends inside " + std::string(what) +
                    ", without a zero byte: it is truncated or damaged; copy it again");
    const auto size = static_cast<std::size_t>(end - rest.begin());
    offset_ += size + 1;
    return {reinterpret_cast<const char*>(rest.data()), size};
}

void ByteCursor::expect_end() const
{
    if (left() > 0)
        throw Error(fmt::format("{}: {} bytes after the expected end: the file is damaged; copy it again", place(), left()));
}

}  // namespace fresco::recordings

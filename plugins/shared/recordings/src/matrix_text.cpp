#include <fresco/recordings/matrix_text.h>

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/value.h>

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <string>

namespace fresco::recordings
{

namespace
{

constexpr std::size_t matrix_file_limit = 1U << 20U;
constexpr double exactness = 1e-6;
constexpr double rotation_tolerance = 1e-2;

bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

std::string_view next_word(std::string_view& line)
{
    std::size_t begin = 0;
    while (begin < line.size() && is_blank(line[begin]))
        ++begin;
    std::size_t end = begin;
    while (end < line.size() && !is_blank(line[end]))
        ++end;
    const auto word = line.substr(begin, end - begin);
    line.remove_prefix(end);
    return word;
}

double parse_number(std::string_view word, const std::string& place)
{
    double number = 0;
    // from_chars knows no leading plus, which some recorders print.
    const auto digits = word.size() > 1 && word[0] == '+' && word[1] != '-' ? word.substr(1) : word;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (code == std::errc::result_out_of_range)
        throw Error(place + ": \"" + std::string(word) + "\" is out of range for a double");
    if (code != std::errc{} || end != digits.data() + digits.size())
        throw Error(place + ": \"" + std::string(word.substr(0, 40)) + "\" is not a number");
    return number;
}

std::vector<double> parse_row(std::string_view line, const std::string& place)
{
    std::vector<double> row;
    for (auto word = next_word(line); !word.empty(); word = next_word(line))
        row.push_back(parse_number(word, place));
    return row;
}

/// With four decimals at most, in any locale.
std::string number_text(double number)
{
    constexpr double decimals = 1e4;
    return to_json(std::round(number * decimals) / decimals);
}

std::string shape_text(int rows, int columns)
{
    return fmt::format("{}x{}", rows, columns);
}

}  // namespace

std::vector<double> parse_matrix_text(std::string_view text, int rows, int columns, std::string_view source)
{
    std::vector<double> values;
    int rows_read = 0;
    for (int line_number = 1; !text.empty(); ++line_number)
    {
        const auto end = text.find('\n');
        const auto line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        const std::string place = fmt::format("{}:{}", source, line_number);
        const auto row = parse_row(line, place);
        if (row.empty())
            continue;
        if (rows_read == rows)
            throw Error(place + ": expected a " + shape_text(rows, columns) + " matrix, but found another row");
        if (row.size() != static_cast<std::size_t>(columns))
            throw Error(fmt::format("{}: {} numbers; a row of a {} matrix has {}", place, row.size(), shape_text(rows, columns),
                                    columns));
        values.insert(values.end(), row.begin(), row.end());
        ++rows_read;
    }
    if (rows_read != rows)
        throw Error(fmt::format("{}: {} rows; expected a {} matrix", source, rows_read, shape_text(rows, columns)));
    return values;
}

std::vector<double> read_matrix_text(const std::filesystem::path& file, int rows, int columns)
{
    return parse_matrix_text(read_text_file(file, matrix_file_limit), rows, columns, file.string());
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
    for (const double entry : matrix)
        if (!std::isfinite(entry))
            throw Error(name + ": the transform has an entry that is not finite; leave this frame out");
    for (std::size_t i = 12; i < 16; ++i)
        if (std::abs(matrix[i] - (i == 15 ? 1.0 : 0.0)) > exactness)
            throw Error(name + ": expected 0 0 0 1 as the last row of a rigid transform");
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

}  // namespace fresco::recordings

#include "odometry.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace stray_scanner
{
namespace
{

using namespace fresco::recordings;

/// The cells of a line, without the blanks around them; a cell may be empty.
std::vector<std::string_view> cells_of(std::string_view line)
{
    std::vector<std::string_view> cells;
    while (true)
    {
        const auto comma = line.find(',');
        auto cell = line.substr(0, comma);
        cell.remove_prefix(std::min(cell.find_first_not_of(" \t\r"), cell.size()));
        cell = cell.substr(0, cell.find_last_not_of(" \t\r") + 1);
        cells.push_back(cell);
        if (comma == std::string_view::npos)
            return cells;
        line.remove_prefix(comma + 1);
    }
}

/// The places of columns by their names in the first line.
class Columns
{
  public:
    Columns(std::string_view line, std::string place) : names_(cells_of(line)), place_(std::move(place)) {}

    std::optional<std::size_t> find(std::string_view name) const
    {
        const auto found = std::ranges::find(names_, name);
        return found == names_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - names_.begin()));
    }
    std::size_t of(std::string_view name) const
    {
        if (const auto column = find(name))
            return *column;
        throw fresco::Error(fmt::format("{}: there is no column \"{}\"; expected the columns of Stray Scanner: timestamp, frame, "
                                        "x, y, z, qx, qy, qz, qw",
                                        place_, name));
    }
    std::size_t count() const { return names_.size(); }

  private:
    std::vector<std::string_view> names_;
    std::string place_;
};

}  // namespace

std::vector<Row> parse_odometry(std::string_view text, std::string_view source)
{
    LineReader lines(text, source);
    const auto first = lines.next_record();
    const Columns columns(first.value_or(""), lines.place());
    std::array<std::size_t, 7> pose_columns{};
    std::ranges::transform(std::array{"x", "y", "z", "qx", "qy", "qz", "qw"}, pose_columns.begin(),
                           [&](const char* name) { return columns.of(name); });
    const auto time = columns.of("timestamp"), frame = columns.of("frame");
    const std::array camera_columns{columns.find("fx"), columns.find("fy"), columns.find("cx"), columns.find("cy")};
    std::vector<Row> rows;
    while (const auto line = lines.next_record())
    {
        const auto cells = cells_of(*line);
        const auto place = lines.place();
        if (cells.size() != columns.count())
            throw fresco::Error(fmt::format("{}: {} values; expected {}, as the first line names them: the file is cut or "
                                            "damaged; copy it again",
                                            place, cells.size(), columns.count()));
        Row row{.time_s = number_of(cells[time], place), .frame = std::string(cells[frame]), .source = place};
        integer_of(row.frame, 0, 1'000'000'000, place);
        if (!rows.empty() && row.time_s <= rows.back().time_s)
            throw fresco::Error(place + ": the time is not later than that of the line before");
        std::array<double, 7> p{};
        bool is_tracked = true;
        for (std::size_t i = 0; i < p.size(); ++i)
        {
            is_tracked = is_tracked && cells[pose_columns[i]] != "nan" && cells[pose_columns[i]] != "-nan";
            if (is_tracked)
                p[i] = number_of(cells[pose_columns[i]], place);
        }
        if (is_tracked)
            row.world_from_camera = quaternion_transform(p[6], p[3], p[4], p[5], {p[0], p[1], p[2]}, place);
        if (std::ranges::all_of(camera_columns, [&](const auto& column) { return column && !cells[*column].empty(); }))
        {
            const auto value = [&](std::size_t i) { return number_of(cells[*camera_columns[i]], place); };
            row.camera = fresco::Intrinsics{0, 0, value(0), value(1), value(2), value(3)};
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

CameraMatrix parse_camera_matrix(std::string_view text, std::string_view source)
{
    std::string spaced(text);
    std::ranges::replace(spaced, ',', ' ');
    return {parse_matrix_text(spaced, 3, 3, source), std::string(source)};
}

}  // namespace stray_scanner

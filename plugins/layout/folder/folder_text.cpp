#include "folder_text.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <algorithm>
#include <fmt/format.h>

namespace folder
{
namespace
{

using namespace fresco::recordings;

constexpr std::size_t short_pose = 12;
constexpr std::size_t full_pose = 16;

std::vector<double> with_last_row(std::vector<double> matrix)
{
    if (matrix.size() == short_pose)
        matrix.insert(matrix.end(), {0, 0, 0, 1});
    return matrix;
}

long rows_of(std::string_view text)
{
    long rows = 0;
    LineReader lines(text, "", LastLine::any);
    while (const auto line = lines.next())
        rows += words_of(*line).empty() ? 0 : 1;
    return rows;
}

}  // namespace

CameraMatrix parse_intrinsics(std::string_view text, const std::string& source)
{
    if (rows_of(text) != 1)
        return {parse_matrix_text(text, 3, 3, source), source};
    const auto line = LineReader(text, source).next_record();
    if (line && words_of(*line) == std::vector<std::string_view>{"equirectangular"})
        return {{}, source};
    const auto k = parse_matrix_text(text, 1, 4, source);
    return {{k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1}, source};
}

std::vector<ListedPose> parse_poses(std::string_view text, std::string_view source)
{
    LineReader lines(text, source);
    std::vector<ListedPose> poses;
    while (const auto line = lines.next_record())
    {
        const auto count = words_of(*line).size();
        if (count != short_pose && count != full_pose)
            throw fresco::Error(fmt::format("{}: {} words; expected the 12 or 16 numbers of a 3x4 or 4x4 matrix, row by row",
                                            lines.place(), count));
        poses.push_back({with_last_row(parse_numbers(*line, count, lines.place())), lines.place()});
    }
    return poses;
}

std::vector<double> parse_pose(std::string_view text, std::string_view source)
{
    const int rows = rows_of(text) == 3 ? 3 : 4;
    // Three rows may be what is left of four.
    if (rows == 3)
        LineReader(text, source).next();
    return with_last_row(parse_matrix_text(text, rows, 4, source));
}

fresco::RigidTransform pose_of(const std::vector<double>& matrix, const PoseConvention& convention, const std::string& source)
{
    auto pose = rigid_transform(matrix, source);
    if (convention.camera_from_world)
        pose = pose.inverse();
    for (int row = 0; convention.opengl && row < 3; ++row)
        for (const int column : {1, 2})
            pose.rotation(row, column) = -pose.rotation(row, column);
    return pose;
}

}  // namespace folder

#include <fresco/recordings/cameras.h>

#include <fresco/recordings/picture_checks.h>

#include <algorithm>
#include <cmath>

namespace fresco::recordings
{

Intrinsics intrinsics_for(const CameraMatrix& matrix, PixelCenter center, const ImageHeader& size,
                          const std::filesystem::path& picture)
{
    const auto k = intrinsics_from_matrix(matrix.values, center, size.width, size.height, matrix.source);
    check_center(k, matrix.source, picture);
    return k;
}

void RecorderCameras::place(RecordedView& view, const RigidTransform& world_from_depth) const
{
    view.camera = color;
    view.world_from_camera = world_from_depth * depth_from_color;
    view.depth_camera = Camera{depth, world_from_depth};
}

std::optional<RigidTransform> tracked_pose(const std::vector<double>& matrix, const std::string& source)
{
    if (!std::all_of(matrix.begin(), matrix.end(), [](double entry) { return std::isfinite(entry); }))
        return std::nullopt;
    return rigid_transform(matrix, source);
}

RigidTransform opencv_pose(std::vector<double> matrix, const std::string& source)
{
    for (std::size_t entry = 0; entry + 4 < matrix.size(); ++entry)
        if (entry % 4 == 1 || entry % 4 == 2)
            matrix[entry] = -matrix[entry];
    return rigid_transform(matrix, source);
}

}  // namespace fresco::recordings

#include "scene_frames.h"

#include <fresco/error.h>
#include <fresco/recording.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace scannet
{

namespace
{

fresco::Intrinsics intrinsics_for(const CameraMatrix& camera, fresco::PixelCenter center, fresco::ImageHeader size,
                                  const std::filesystem::path& picture)
{
    const auto k = fresco::intrinsics_from_matrix(camera.matrix, center, size.width, size.height, camera.source);
    fresco::check_center(k, camera.source, picture);
    return k;
}

/// Nothing where the recorder had lost track and wrote inf.
std::optional<fresco::RigidTransform> tracked_pose(const std::filesystem::path& file)
{
    const auto matrix = fresco::read_matrix_text(file, 4, 4);
    if (!std::all_of(matrix.begin(), matrix.end(), [](double entry) { return std::isfinite(entry); }))
        return std::nullopt;
    return fresco::rigid_transform(matrix, file.string());
}

}  // namespace

SceneFrames scene_frames(const std::vector<fresco::ViewFiles>& views, const SceneCalibration& calibration,
                         fresco::PixelCenter center, const fresco::ImageIo& images, fresco::Progress& progress)
{
    const auto& first = views.at(0);
    const fresco::RecorderCameras cameras{intrinsics_for(calibration.color, center, images.header(first.color), first.color),
                                          intrinsics_for(calibration.depth, center, images.header(first.depth), first.depth),
                                          calibration.depth_from_color};
    SceneFrames scene;
    scene.frames = fresco::posed_frames(
        views, cameras, [](const fresco::ViewFiles& view) { return tracked_pose(view.pose); }, images, progress);
    scene.not_tracked = views.size() - scene.frames.frames.size();
    if (scene.frames.frames.empty())
        throw fresco::Error(first.pose.parent_path().string() + ": none of the " + std::to_string(views.size()) +
                            " poses is finite: the recorder never knew where it was, this scene cannot be used");
    return scene;
}

void transform_scene(const fresco::RigidTransform& new_from_old, fresco::Frames& frames, fresco::Mesh& mesh)
{
    for (auto& frame : frames.frames)
    {
        frame.color.world_from_camera = new_from_old * frame.color.world_from_camera;
        frame.depth.world_from_camera = new_from_old * frame.depth.world_from_camera;
    }
    for (auto& position : mesh.positions)
        position = fresco::vec_cast<float>(new_from_old.point(fresco::vec_cast<double>(position)));
}

}  // namespace scannet

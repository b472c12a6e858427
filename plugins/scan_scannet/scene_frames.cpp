#include "scene_frames.h"

#include <fresco/error.h>
#include <fresco/hash.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

namespace scannet
{

namespace
{

std::string size_text(int width, int height)
{
    return std::to_string(width) + "x" + std::to_string(height);
}

void check_size(const std::filesystem::path& file, fresco::ImageHeader header, const fresco::Intrinsics& expected)
{
    if (header.width != expected.width || header.height != expected.height)
        throw fresco::Error(file.string() + ": the picture is " + size_text(header.width, header.height) +
                            ", the scene's first is " + size_text(expected.width, expected.height) +
                            "; all pictures of one camera must have one size");
}

fresco::Intrinsics intrinsics_for(const CameraMatrix& camera, fresco::PixelCentre centre, fresco::ImageHeader size,
                                  const std::filesystem::path& picture)
{
    const auto k = fresco::intrinsics_from_matrix(camera.matrix, centre, size.width, size.height, camera.source);
    if (k.cx <= 0 || k.cy <= 0 || k.cx >= k.width || k.cy >= k.height)
        throw fresco::Error(camera.source + ": the centre (" + std::to_string(k.cx) + ", " + std::to_string(k.cy) +
                            ") is outside of " + picture.string() + ", which is " + size_text(k.width, k.height) +
                            "; the pictures must have the size they were calibrated at");
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

SceneFrames scene_frames(const std::vector<ViewFiles>& views, const SceneCalibration& calibration, fresco::PixelCentre centre,
                         const std::string& sequence, const fresco::ImageIo& images, fresco::Progress& progress)
{
    const auto& first = views.at(0);
    const auto color_k = intrinsics_for(calibration.color, centre, images.header(first.color), first.color);
    const auto depth_k = intrinsics_for(calibration.depth, centre, images.header(first.depth), first.depth);

    std::vector<std::optional<fresco::Frame>> made(views.size());
    std::atomic<std::size_t> done{0};
    fresco::parallel_for(
        views.size(), 4, progress.threads(),
        [&](std::size_t begin, std::size_t end)
        {
            for (std::size_t i = begin; i < end; ++i)
            {
                progress.check_cancelled();
                progress.progress(static_cast<double>(++done), static_cast<double>(views.size()), "frames");
                const auto pose = tracked_pose(views[i].pose);
                if (!pose)
                    continue;
                check_size(views[i].color, images.header(views[i].color), color_k);
                check_size(views[i].depth, images.header(views[i].depth), depth_k);
                fresco::Frame frame;
                frame.sequence = sequence;
                frame.name = std::to_string(views[i].number);
                frame.number = views[i].number;
                frame.color = {color_k, *pose * calibration.depth_from_color};
                frame.depth = {depth_k, *pose};
                frame.color_picture = {std::filesystem::absolute(views[i].color), fresco::file_hash(views[i].color)};
                frame.depth_picture = {std::filesystem::absolute(views[i].depth), fresco::file_hash(views[i].depth)};
                fresco::check_camera(frame.color, views[i].pose.string());
                fresco::check_camera(frame.depth, views[i].pose.string());
                made[i] = std::move(frame);
            }
        });

    SceneFrames scene;
    for (auto& frame : made)
        if (frame)
            scene.frames.frames.push_back(std::move(*frame));
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

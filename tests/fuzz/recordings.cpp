#include "parsers.h"

#include "plugins/layout/colmap/model.h"
#include "plugins/layout/matterport3d/house.h"
#include "plugins/layout/nerfstudio/transforms.h"
#include "plugins/layout/polycam/keyframes.h"
#include "plugins/layout/record3d/lzfse.h"
#include "plugins/layout/record3d/metadata.h"
#include "plugins/layout/replica/replica_scene.h"
#include "plugins/layout/scannet/scene_calibration.h"
#include "plugins/layout/sens/sens_file.h"
#include "plugins/layout/stray_scanner/odometry.h"
#include "plugins/layout/tum/tum.h"

#include <fresco/error.h>
#include <fresco/recordings/lens.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/testing.h>

namespace fresco::fuzz
{
namespace
{

const std::string name(source);

void check(const RigidTransform& transform)
{
    require(transform.rotation_error() < 1e-6, "a rotation");
}

/// Frames whose lens does not fit their camera are refused.
void check_lens(const recordings::Lens& lens, const Intrinsics& camera)
{
    const Intrinsics pinhole = pinhole_without(lens, camera, source);
    require(pinhole.width == camera.width && pinhole.height == camera.height, "a camera of the same size");
}

void read_sens(Bytes bytes)
{
    const sens::SensFile file(file_with(bytes, "scene.sens"));
    const auto index = sens::read_index(file);
    for (const auto& frame : index.frames)
    {
        file.read_at(frame.color_offset, frame.color_bytes, "the color picture");
        const auto depth = file.read_at(frame.depth_offset, frame.depth_bytes, "the depth picture");
        if (index.depth_form == sens::DepthForm::zlib)
            sens::unpack_depth(depth, index.depth.width, index.depth.height, name);
    }
}

void read_sens_depth(Bytes bytes)
{
    if (bytes.size() < 2)
        throw Error("no size");
    const int width = 1 + std::to_integer<int>(bytes[0]);
    const int height = 1 + std::to_integer<int>(bytes[1]);
    const auto depth = sens::unpack_depth(bytes.subspan(2), width, height, name);
    require(depth.values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height), "a value per pixel");
}

/// Two parsers for the same bytes, of which one may refuse them.
template <class First, class Second>
void read_by_either(const First& first, const Second& second)
{
    if (refused(first))
        second();
    else
        refused(second);
}

void read_colmap(Bytes bytes)
{
    read_by_either(
        [&]
        {
            for (const auto& [id, camera] : colmap::parse_cameras_binary(bytes, source))
                check_lens(camera.lens, camera.intrinsics);
        },
        [&]
        {
            for (const auto& image : colmap::parse_images_binary(bytes, source))
                check(image.world_from_camera);
        });
}

/// Both text files of a model in one: the images behind a line "images".
void read_colmap_text(Bytes bytes)
{
    constexpr std::string_view border = "images\n";
    const std::string_view text = text_of(bytes);
    const auto at = std::min(text.find(border), text.size());
    const auto cameras = colmap::parse_cameras_text(text.substr(0, at), source);
    const auto images = colmap::parse_images_text(text.substr(std::min(at + border.size(), text.size())), source);
    colmap::model_views(cameras, images, "images.txt", {});
}

/// A list, or those of color, depth and poses behind one another, each ended by a line "---".
void read_tum(Bytes bytes)
{
    constexpr std::string_view border = "---\n";
    const std::string_view text = text_of(bytes);
    if (const auto first = text.find(border); first != std::string_view::npos)
    {
        const auto second = std::min(text.find(border, first + border.size()), text.size());
        const auto color = tum::parse_pictures(text.substr(0, first), "rgb.txt");
        const auto depth = tum::parse_pictures(text.substr(first + border.size(), second - first - border.size()), "depth.txt");
        const auto poses = tum::parse_poses(text.substr(std::min(second + border.size(), text.size())), "groundtruth.txt");
        const auto found = tum::associate(color, depth, poses, 0.02, "folder");
        tum::gaps_text(found);
        require(found.views.size() + found.without_depth + found.without_pose == color.size(),
                "each picture is found or counted");
        for (const auto& view : found.views)
            check(view.world_from_camera);
        return;
    }
    read_by_either(
        [&]
        {
            for (const auto& pose : tum::parse_poses(text_of(bytes), source))
                check(pose.world_from_camera);
        },
        [&]
        {
            const auto pictures = tum::parse_pictures(text_of(bytes), source);
            tum::associate(pictures, pictures, {{pictures.front().time_s, {}, name}}, 1, "folder");
        });
}

/// 7-Scenes' and ScanNet's poses and cameras.
void read_matrix(Bytes bytes)
{
    const auto matrix = recordings::parse_matrix_text(text_of(bytes), 4, 4, source);
    if (matrix[0] > 2)
        recordings::intrinsics_from_matrix(matrix, recordings::PixelCenter::integer, 640, 480, source);
    else if (const auto pose = recordings::tracked_pose(matrix, name))
        check(*pose);
}

void read_scannet(Bytes bytes)
{
    static fresco::testing::TestRun run;
    run.files_read.clear();
    run.folders_read.clear();
    const auto file = file_with(bytes, "scene0000_00.txt");
    const auto calibration = scannet::read_scene_calibration(file.parent_path() / "scene0000_00", file, run);
    for (const auto& camera : {calibration.color, calibration.depth})
        recordings::intrinsics_from_matrix(camera.values, recordings::PixelCenter::integer, 640, 480, camera.source);
}

void read_matterport_house(Bytes bytes)
{
    matterport3d::parse_regions(text_of(bytes), source);
}

void read_matterport_cameras(Bytes bytes)
{
    for (const auto& view : matterport3d::parse_cameras(text_of(bytes), source).views)
    {
        check(view.world_from_camera);
        matterport3d::camera_of(view, 1280, 1024);
    }
}

void read_nerfstudio(Bytes bytes)
{
    testing::TestRun run(1);
    for (const bool original : {false, true})
        for (const auto& view : nerfstudio::parse_transforms(text_of(bytes), name, {.original_world = original}, run))
        {
            if (std::isfinite(view.world_from_camera.translation.x))
                check(view.world_from_camera);
            check_lens(view.lens, view.camera);
        }
}

void read_lzfse(Bytes bytes)
{
    if (bytes.size() < 2)
        throw Error("no size");
    const auto size = std::to_integer<std::size_t>(bytes[0]) + 256 * std::to_integer<std::size_t>(bytes[1]);
    require(record3d::unpack_lzfse(bytes.subspan(2), size, name).size() == size, "the size that was asked for");
}

void read_record3d(Bytes bytes)
{
    for (const auto& pose : record3d::parse_metadata(text_of(bytes), source).world_from_camera)
        if (pose)
            check(*pose);
}

void read_stray_scanner(Bytes bytes)
{
    for (const auto& row : stray_scanner::parse_odometry(text_of(bytes), source))
        if (row.world_from_camera)
            check(*row.world_from_camera);
}

void read_polycam(Bytes bytes)
{
    const Value root = parse_json(text_of(bytes), source);
    if (root.find("alignmentTransform") != nullptr)
        return check(polycam::parse_alignment(text_of(bytes), source));
    recordings::RecordedView view;
    polycam::parse_camera(text_of(bytes), view);
    check(view.world_from_camera);
}

void read_replica(Bytes bytes)
{
    if (text_of(bytes).starts_with('{'))
        replica::parse_camera(text_of(bytes), source);
    else
        for (const auto& pose : replica::parse_trajectory(text_of(bytes), source))
            check(pose);
}

const Registered registered{
    {"sens", "plugins/layout/sens/sens_file\\.cpp", read_sens},
    {"sens_depth", "plugins/layout/sens/sens_file\\.cpp", read_sens_depth},
    {"colmap_binary", "plugins/layout/colmap/model\\.cpp|plugins/shared/recordings/src/parsing\\.cpp", read_colmap},
    {"colmap_text", "plugins/layout/colmap/model\\.cpp", read_colmap_text},
    {"poses_tum", "plugins/layout/tum/tum\\.cpp|plugins/shared/recordings/src/parsing\\.cpp", read_tum},
    {"poses_matrix", "plugins/shared/recordings/src/parsing\\.cpp", read_matrix},
    {"poses_scannet", "plugins/layout/scannet/scene_calibration\\.cpp", read_scannet},
    {"poses_matterport", "plugins/layout/matterport3d/house\\.cpp", read_matterport_cameras},
    {"house_matterport", "plugins/layout/matterport3d/house\\.cpp", read_matterport_house},
    {"poses_nerfstudio", "plugins/layout/nerfstudio/transforms\\.cpp|plugins/shared/recordings/src/parsing\\.cpp",
     read_nerfstudio},
    {"poses_polycam", "plugins/layout/polycam/keyframes\\.cpp", read_polycam},
    {"lzfse", "plugins/layout/record3d/lzfse\\.cpp", read_lzfse},
    {"poses_record3d", "plugins/layout/record3d/metadata\\.cpp", read_record3d},
    {"poses_stray_scanner", "plugins/layout/stray_scanner/odometry\\.cpp", read_stray_scanner},
    {"poses_replica", "plugins/layout/replica/replica_scene\\.cpp", read_replica}};

}  // namespace
}  // namespace fresco::fuzz

#pragma once

#include "mistakes.h"

#include <string>
#include <utility>
#include <vector>

/// \file Mistakes made on purpose, and recordings that only look odd.

namespace mistakes
{

struct Case
{
    std::string name;
    Change change;
    std::vector<std::string> causes;  ///< What is to be found: nothing else, in this order.
};

/// Every mistake that has a name.
inline std::vector<Case> named()
{
    const auto turned = [](Vec3f p) { return Vec3f{p.x, p.z, -p.y}; };
    const auto mirrored = [](Vec3f p) { return Vec3f{-p.x, p.y, p.z}; };
    const auto on_principal = [](Looked& looked)
    {
        for (View& view : looked.views)
            view.color.cx += 0.04 * view.color.width;
    };
    return {{"OpenGL axes", on_poses(opengl), {"opengl_axes"}},
            {"inverted poses", read_as(Reading::inverted), {"inverted_poses"}},
            {"inverted poses with OpenGL axes",
             both(on_poses(opengl), read_as(Reading::inverted)),
             {"inverted_poses", "opengl_axes"}},
            {"other camera axes",
             on_poses([](RigidTransform& pose) { pose.rotation = pose.rotation * axis_rotations()[9]; }),
             {"camera_axes"}},
            {"transposed rotations", read_as(Reading::transposed), {"transposed_rotations"}},
            {"quaternions w x y z taken for x y z w", read_as(Reading::scalar_last), {"quaternion_order"}},
            {"quaternions x y z w taken for w x y z", read_as(Reading::scalar_first), {"quaternion_order"}},
            {"COLMAP's quaternions as x y z w", read_as(Reading::inverted_scalar_last), {"quaternion_order"}},
            {"COLMAP's quaternions reversed", read_as(Reading::inverted_scalar_first), {"quaternion_order"}},
            {"poses in millimeters", scaled_poses(1000), {"millimeter_poses"}},
            {"poses in centimeters", scaled_poses(100), {"pose_unit"}},
            {"poses in feet", scaled_poses(3.2808), {"pose_unit"}},
            {"poses in COLMAP's unit", scaled_poses(0.173), {"pose_unit"}},
            {"poses 12 % too far apart", scaled_poses(1.12), {"pose_unit"}},
            {"poses with OpenGL axes in any unit", both(on_poses(opengl), scaled_poses(7.4)), {"opengl_axes", "pose_unit"}},
            {"a mesh in millimeters", scaled_mesh(1000), {"millimeter_mesh"}},
            {"a mesh in centimeters", scaled_mesh(100), {"mesh_unit"}},
            {"a mesh in any unit", scaled_mesh(0.37F), {"mesh_unit"}},
            {"mesh and poses in millimeters", both(scaled_mesh(1000), scaled_poses(1000)), {"millimeter_world"}},
            {"mesh and poses in COLMAP's unit", both(scaled_mesh(1.9F), scaled_poses(1.9)), {"depth_unit"}},
            {"millimeters of depth taken for meters", scaled_depths(1000), {"millimeter_depth"}},
            {"quarters of a millimeter taken for millimeters", scaled_depths(4), {"depth_unit"}},
            {"a world turned", on_mesh(turned), {"world_axes"}},
            {"a mirrored mesh", on_mesh(mirrored), {"mirrored_mesh"}},
            {"a mirrored mesh, faces turned", both(on_mesh(mirrored), turn_faces), {"mirrored_mesh"}},
            {"a mesh 10 cm off", moved_mesh({0.1F, 0, 0}), {"mesh_moved"}},
            {"a mesh 20 cm off", moved_mesh({0.1F, -0.12F, 0.12F}), {"mesh_moved"}},
            {"inside out", turn_faces, {"faces_inside_out"}},
            {"poses of the frame before", late_poses(1), {"pose_lag"}},
            {"poses of the frame after", late_poses(-1), {"pose_lag"}},
            {"poses 2.4 frames late", late_poses(2.4), {"pose_lag"}},
            {"distances along rays", on_depths(measure_along_rays), {"ray_depth"}},
            {"upside down", both(turn_depth, turn_color), {"upside_down"}},
            {"depth upside down", turn_depth, {"depth_upside_down"}},
            {"color upside down", turn_color, {"color_upside_down"}},
            {"intrinsics of pictures twice the size", intrinsics(2, 2), {"camera_size"}},
            {"intrinsics of pictures half the size", intrinsics(0.5, 0.5), {"camera_size"}},
            {"the depth camera's twice the size", intrinsics(1, 2), {"depth_camera_size"}},
            {"the depth camera's half the size", intrinsics(1, 0.5), {"depth_camera_size"}},
            {"the color camera's twice the size", intrinsics(2, 1), {"color_camera_size"}},
            {"the color camera's half the size", intrinsics(0.5, 1), {"color_camera_size"}},
            {"the color camera's for 1.5 times the size", intrinsics(1.5, 1), {"color_camera_size"}},
            {"color taken for depth", color_as_depth, {"color_taken_for_depth"}},
            {"depth taken for color", depth_as_color, {"depth_taken_for_color"}},
            {"cameras swapped", swap_cameras, {"cameras_swapped"}},
            {"color's principal point 4 % too far right", on_principal, {"color_shift"}},
            {"color's focal length 10 % too small", intrinsics(1, 1, 0.9, 1), {"color_focal_length"}},
            {"color's focal length 10 % too large", intrinsics(1, 1, 1.1, 1), {"color_focal_length"}},
            {"depth's focal length 10 % too small", intrinsics(1, 1, 1, 0.9), {"depth_focal_length"}},
            {"depth's focal length 10 % too large", intrinsics(1, 1, 1, 1.1), {"depth_focal_length"}},
            {"both focal lengths 10 % too large", intrinsics(1, 1, 1.1, 1.1), {"focal_length"}},
            {"OpenGL axes and a focal length",
             both(on_poses(opengl), intrinsics(1, 1, 1, 1.1)),
             {"opengl_axes", "depth_focal_length"}},
            {"red and blue exchanged", exchange_channels, {"red_and_blue_exchanged"}},
            {"depth registered to color", register_depth, {"depth_by_color_camera"}}};
}

/// What the pictures tell without depth.
inline std::vector<Case> named_by_edges()
{
    return {{"no depth, OpenGL axes", both(drop_depth, on_poses(opengl)), {"opengl_axes"}},
            {"no depth, poses in millimeters", both(drop_depth, scaled_poses(1000)), {"millimeter_poses"}},
            {"no depth, a mesh in millimeters", both(drop_depth, scaled_mesh(1000)), {"millimeter_mesh"}},
            {"no depth, upside down", both(drop_depth, turn_color), {"color_upside_down"}}};
}

/// Recordings that are right.
inline std::vector<std::pair<std::string, Change>> right()
{
    const auto nothing = [](Looked&) {};
    const auto part_of_picture = [](const View& view, const DepthSample& sample, double)
    { return sample.x < 0.3F * static_cast<float>(view.depth.depth.width); };
    const auto near = [](float reach)
    { return [reach](const View&, const DepthSample& sample, double) { return sample.depth < reach; }; };
    const auto few = [](double share)
    { return [share](const View&, const DepthSample&, double chance) { return chance < share; }; };
    const auto no_colors = [](Looked& looked) { looked.mesh.colors.clear(); };
    const auto one_color = [](Looked& looked) { std::ranges::fill(looked.mesh.colors, Rgb8{120, 130, 120}); };
    const auto bluish = [](Looked& looked)
    {
        for (Rgb8& color : looked.mesh.colors)
            color[2] = static_cast<std::uint8_t>(std::min(255, color[2] + 70));
    };
    return {{"as recorded", nothing},
            {"the left half", crop({0, 0, 0}, {0.5F, 1, 1})},
            {"the right third", crop({0.67F, 0, 0}, {1, 1, 1})},
            {"one wall", crop({0, 0, 0}, {1, 0.08F, 1})},
            {"the floor", crop({0, 0, 0}, {1, 1, 0.1F})},
            {"below a meter", crop({0, 0, 0}, {1, 1, 0.4F})},
            {"above a meter", crop({0, 0, 0.4F}, {1, 1, 1})},
            {"one object", crop({0.3F, 0.3F, 0.05F}, {0.7F, 0.7F, 0.5F})},
            {"a small object", crop({0.4F, 0.35F, 0.2F}, {0.6F, 0.65F, 0.5F})},
            {"a corner", crop({0, 0, 0}, {0.3F, 0.3F, 1})},
            {"small holes", holes(200, 0.08F)},
            {"large holes", holes(30, 0.4F)},
            {"holes nearly everywhere", holes(60, 0.5F)},
            {"1 % of noise", depth_noise(0.01, 0)},
            {"2 cm of noise", depth_noise(0, 0.02)},
            {"a rough mesh", mesh_noise(0.006F)},
            {"a rough part", both(mesh_noise(0.006F), crop({0, 0, 0}, {0.5F, 1, 1}))},
            {"drifting poses", pose_noise(0.01, 0.005)},
            {"one frame", keep_views(1)},
            {"two frames", keep_views(2)},
            {"three frames of a part", both(keep_views(3), crop({0, 0, 0}, {0.5F, 1, 1}))},
            {"depth to 2 m", keep_depths(near(2))},
            {"little depth", keep_depths(few(0.1))},
            {"depth on the left only", keep_depths(part_of_picture)},
            {"no depth", drop_depth},
            {"no depth, the left half", both(drop_depth, crop({0, 0, 0}, {0.5F, 1, 1}))},
            {"no pictures", drop_color},
            {"a mesh without colors", no_colors},
            {"a gray mesh", one_color},
            {"a mesh of another white balance", bluish},
            {"a board that was carried off", add_board},
            {"one camera", both(register_depth, depth_as_color)},
            {"one camera, the left half", both(both(register_depth, depth_as_color), crop({0, 0, 0}, {0.5F, 1, 1}))},
            {"focal lengths off by 1.5 %", intrinsics(1, 1, 1.015, 1.015)},
            {"poses 0.15 frames late", late_poses(0.15)}};
}

}  // namespace mistakes

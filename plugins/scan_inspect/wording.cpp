#include "wording.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fresco::inspect
{
namespace
{

/// No room measures as many meters.
constexpr double largest_room = 150;
constexpr double alike_focals = 0.05;

void tell_units(double pose_scale, double depth_scale, double extent, std::vector<Finding>& findings)
{
    const bool large = extent > largest_room;
    if (pose_scale == 1000 && (depth_scale == 1000 || large))
    {
        findings.push_back({"millimeter_mesh",
                            "the mesh is in millimeters where the poses are in meters: read it with scan.mesh and "
                            "unit_m: 0.001"});
        return;
    }
    if (pose_scale > 1 && (depth_scale == pose_scale || large))
    {
        findings.push_back({"mesh_unit", "the mesh is in another unit than the poses: read it with scan.mesh and unit_m: " +
                                             number(1 / pose_scale)});
        return;
    }
    if (pose_scale == 1 && depth_scale == 1000 && large)
    {
        findings.push_back(
            {"millimeter_world", "mesh and poses are in millimeters where the depth is in meters: scale both by 0.001"});
        return;
    }
    if (pose_scale == 0.001)
        findings.push_back(
            {"millimeter_poses", "the poses' translations are in millimeters where the mesh is in meters: divide them by 1000"});
    else if (pose_scale != 1)
        findings.push_back(
            {"pose_unit", "the poses' translations are not in the mesh's unit: multiply them by " + number(pose_scale)});
    if (depth_scale == 0.001)
        findings.push_back({"millimeter_depth", "depths come out 1000 times too large: the depth pictures hold millimeters, set "
                                                "depth_unit_m: 0.001"});
    else if (depth_scale != 1)
        findings.push_back({"depth_unit", "depths are not in the mesh's unit: multiply depth_unit_m by " + number(depth_scale)});
}

/// "10 % too large" for a factor of 0.91 that mends it.
std::string how_far_off(double mending_factor)
{
    const double off = 1 / mending_factor - 1;
    return percent(std::abs(off)) + (off > 0 ? " too large" : " too small");
}

/// With what to do: the factor, where it was found within `reach` and not at the end of what was looked through.
std::string how_to_mend(double factor, double reach)
{
    constexpr double hair = 1e-6;
    if (std::abs(std::log(factor)) < reach - hair)
        return how_far_off(factor) + ": multiply it by " + number(factor);
    return how_far_off(factor) + " or more: was it calibrated for another picture size?";
}

}  // namespace

std::string percent(double share)
{
    return std::to_string(std::lround(100 * share)) + " %";
}

std::string number(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    std::replace(text, text + sizeof text, ',', '.');
    return value == 1000 ? "1000" : text;
}

std::string summary(const Diagnosis& diagnosis)
{
    const Agreement& recorded = diagnosis.recorded;
    std::string text;
    if (diagnosis.depths > 0)
        text = percent(recorded.depth_share) + " of the depths are within 3 % of the mesh's (median difference " +
               number(100 * recorded.depth_median_error) + " %)";
    if (diagnosis.outline_points > 0)
        text += std::string(text.empty() ? "" : ", ") + "the pictures' edges are " + number(1 + recorded.edge_response) +
                " times as strong along the mesh's outline as elsewhere";
    if (text.empty())
        return "nothing to compare: the frames have no depth, and no pictures in which the mesh has an outline";
    const bool clear = diagnosis.depths == 0 || recorded.depth_clear();
    const char* const verdict = !diagnosis.findings.empty() ? "as recorded: "
                                : clear                     ? "mesh and frames agree: "
                                                            : "mesh and frames agree in part, look at the picture: ";
    return verdict + text;
}

double mesh_extent(const Mesh& mesh)
{
    Vec3f low = mesh.positions.front();
    Vec3f high = low;
    for (const Vec3f p : mesh.positions)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return static_cast<double>(length(high - low));
}

void tell_convention(const Convention& convention, double depth_scale, double extent, std::vector<Finding>& findings)
{
    if (convention.inverted)
        findings.push_back(
            {"inverted_poses", "the poses are inverted, camera_from_world where world_from_camera is expected: invert them"});
    if (convention.camera_turn == axis_rotations()[1])
        findings.push_back({"opengl_axes",
                            "the poses have OpenGL's camera axes (y up, z backward) where OpenCV's (y down, z forward) are "
                            "expected: negate the second and third columns of their rotations"});
    else if (!(convention.camera_turn == Mat3{}))
        findings.push_back({"camera_axes", "the poses have other camera axes than OpenCV's: right, down and forward are their " +
                                               axis_names(convention.camera_turn)});
    if (!(convention.world_turn == Mat3{}))
    {
        std::string axes = axis_names(convention.world_turn);
        std::erase(axes, '+');
        findings.push_back(
            {"world_axes",
             "mesh and poses are rotated against each other: read the mesh with scan.mesh and axes: \"" + axes + "\""});
    }
    tell_units(convention.scale, depth_scale, extent, findings);
}

void tell_cameras(const Diagnosis& diagnosis, bool one_camera, std::vector<Finding>& findings)
{
    const double depth = diagnosis.depth_focal_scale;
    const CameraChange& color = diagnosis.color_change;
    const bool depth_off = depth != 1;
    const bool color_off = color.focal_scale != 1 || color.shift_x != 0 || color.shift_y != 0;
    if (diagnosis.depth_by_color_camera && color_off)
    {
        findings.push_back({"cameras_swapped", "the color and depth cameras are swapped: exchange their intrinsics and poses"});
        return;
    }
    if (diagnosis.depth_by_color_camera)
        findings.push_back({"depth_by_color_camera",
                            "the depth pictures fit the color camera, not the depth camera: "
                            "they are registered to color; use the color camera's intrinsics and pose for them"});
    if (depth_off && color_off && std::abs(std::log(depth / color.focal_scale)) < alike_focals)
    {
        findings.push_back({"focal_length", "the focal length of both cameras is " + how_to_mend(depth, color_focal_reach)});
        return;
    }
    if (depth_off && one_camera && !color_off)
        findings.push_back({"depth_taken_for_color", "both cameras have the same intrinsics, which fit only the color "
                                                     "pictures; the depth camera's focal length is " +
                                                         number(depth) + " times as large"});
    else if (depth_off)
        findings.push_back(
            {"depth_focal_length", "the focal length of the depth camera is " + how_to_mend(depth, depth_focal_reach)});
    if (!color_off)
        return;
    const bool focal_off = std::abs(std::log(color.focal_scale)) > 0.025;
    if (one_camera && diagnosis.depths > 0 && !depth_off)
        findings.push_back({"color_taken_for_depth", "both cameras have the same intrinsics, which fit only the depth "
                                                     "pictures; the color camera's focal length is about " +
                                                         number(color.focal_scale) + " times as large"});
    else if (focal_off)
        findings.push_back({"color_focal_length",
                            "the focal length of the color camera is " + how_to_mend(color.focal_scale, color_focal_reach)});
    else
        findings.push_back(
            {"color_shift", "the color pictures are shifted against the mesh: their principal point is off by about (" +
                                number(100 * color.shift_x) + ", " + number(100 * color.shift_y) +
                                ") % of the picture, or the color camera's position is wrong"});
}

void tell_inside_out(double front_share, std::vector<Finding>& findings)
{
    findings.push_back({"faces_inside_out", "the mesh is inside out: cameras see the front of a face at only " +
                                                percent(front_share) + " of its pixels; swap two corners of every face"});
}

void tell_unexplained_depth(const Diagnosis& diagnosis, std::vector<Finding>& findings)
{
    findings.push_back(
        {"unexplained", "only " + percent(diagnosis.explained.depth_share) +
                            " of the depths are within 3 % of the mesh, and no usual mistake explains it: do mesh and "
                            "frames belong together?"});
}

void tell_unexplained_edges(const Diagnosis& diagnosis, std::vector<Finding>& findings)
{
    if (diagnosis.seen_share == 0)
        findings.push_back(
            {"unexplained", "no frame sees the mesh, and no usual mistake explains it: do mesh and frames belong together?"});
    else
        findings.push_back({"unexplained_edges",
                            "the color pictures have no edges where the mesh has its outline, and no usual mistake "
                            "explains it: look at the pictures"});
}

}  // namespace fresco::inspect

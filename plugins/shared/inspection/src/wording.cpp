#include <fresco/inspection/wording.h>

#include "explain_depths.h"

#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace fresco::inspect
{

std::string number(double value)
{
    return value == 1000 ? "1000" : fmt::format("{:.3g}", value);
}

void tell(std::vector<Finding>& findings, const char* cause, std::string text, bool certain)
{
    findings.push_back({cause, std::move(text), certain});
}

namespace
{

using Findings = std::vector<Finding>;

/// "95 %".
std::string percent(double share)
{
    return std::to_string(std::lround(100 * share)) + " %";
}

const char* const negate_columns = "negate the second and third columns of their rotations";
const char* const opengl_files = " files with OpenGL's axes (transforms.json, layout.folder with axes: opengl)";

/// Whether inverting what a reader made of files with OpenGL's axes tells what to do with the files: their axes turn the world,
/// which frames among themselves do not see, or the mesh.
bool tells_of_opengl_files(const Assumption& a, double extent)
{
    return a.reading == Reading::inverted && (extent == 0 || a.world_turn == axis_rotations()[1]);
}

void tell_reading(const Assumption& a, double extent, Findings& findings)
{
    switch (a.reading)
    {
    case Reading::inverted:
        tell(findings, "inverted_poses",
             std::string("the poses are inverted, camera_from_world where world_from_camera is expected: invert them (with "
                         "layout.folder, set direction to its other value)") +
                 (a.camera_turn == Mat3{} && tells_of_opengl_files(a, extent)
                      ? std::string("; in") + opengl_files + ", also " + negate_columns + " afterward"
                      : ""));
        break;
    case Reading::transposed:
        tell(findings, "transposed_rotations",
             "the poses' rotations are transposed (stored column by column): transpose them, and keep the positions");
        break;
    case Reading::scalar_first:
    case Reading::inverted_scalar_first:
        tell(findings, "quaternion_order",
             "the poses' quaternions are w x y z where x y z w is expected: move the first number to the end");
        break;
    case Reading::scalar_last:
    case Reading::inverted_scalar_last:
        tell(findings, "quaternion_order",
             "the poses' quaternions are x y z w where w x y z is expected: move the last number to the front");
        break;
    default:
        break;
    }
}

void tell_axes(const Assumption& a, double extent, bool inside_out, Findings& findings)
{
    if (a.camera_turn == axis_rotations()[1] && tells_of_opengl_files(a, extent))
        tell(findings, "opengl_axes",
             std::string("the inverted poses have OpenGL's camera axes (y up, z backward) where OpenCV's (y down, z forward) are "
                         "expected: ") +
                 negate_columns + " afterward, but not in" + opengl_files);
    else if (a.camera_turn == axis_rotations()[1])
        tell(findings, "opengl_axes",
             std::string("the poses have OpenGL's camera axes (y up, z backward) where OpenCV's (y down, z forward) are "
                         "expected, or OpenCV's in a transforms.json, which has OpenGL's: ") +
                 negate_columns + " (with layout.folder, set axes to its other value)");
    else if (!(a.camera_turn == Mat3{}))
        tell(findings, "camera_axes",
             "the poses have other camera axes than OpenCV's: right, down and forward are their " + axis_names(a.camera_turn));
    if (a.world_turn == Mat3{})
        return;
    std::string axes = axis_names(a.world_turn);
    std::erase(axes, '+');
    if (determinant(a.world_turn) > 0)
        tell(findings, "world_axes",
             "mesh and poses are rotated against each other: read the mesh with scan.mesh and axes: \"" + axes + "\"" +
                 (tells_of_opengl_files(a, extent) ? std::string(", but not with") + opengl_files : ""));
    else
        tell(findings, "mirrored_mesh",
             "the mesh is mirrored: export it again without mirroring, or replace each vertex's x y z by its " + axes +
                 (inside_out ? "" : " and swap two corners of every face"));
}

/// "depth_unit_m by 0.2 (0.0002 if it is 0.001)": users who never set the option do not know its value.
std::string depth_unit_by(double factor)
{
    return "depth_unit_m by " + number(factor) + " (" + number(0.001 * factor) + " if it is 0.001)";
}

void tell_units(const Assumption& a, double extent, Findings& findings)
{
    const double poses = a.pose_scale;
    const double depths = a.depth_scale;
    const bool large = extent > largest_room;
    if (extent == 0 && poses != 1)
    {
        tell(findings, poses == 0.001 ? "millimeter_poses" : "pose_unit",
             "the poses' positions and the depths are in different units: multiply the positions by " + number(poses) +
                 " (unit_m of scan.recording) or, if these are in meters, " + depth_unit_by(1 / poses));
        return;
    }
    const auto unit = [](double scale)
    { return "read it with scan.mesh and multiply unit_m of scan.mesh by " + number(1 / scale); };
    if (poses != 1 && (std::abs(std::log(depths / poses)) < 0.03 || (poses > 1 && large)))
    {
        if (poses == 1000)
            tell(findings, "millimeter_mesh", "the mesh is in millimeters where the poses are in meters: " + unit(poses));
        else
            tell(findings, "mesh_unit",
                 "the mesh is in another unit than poses and depths, 1 m is " + number(poses) + " of it: " + unit(poses));
        return;
    }
    if (poses == 1 && depths == 1000 && large)
    {
        tell(findings, "millimeter_world",
             "mesh and poses are in millimeters where the depth is in meters: scale both by 0.001 (unit_m)");
        return;
    }
    if (poses == 0.001)
        tell(findings, "millimeter_poses",
             "the poses' positions are in millimeters where the mesh is in meters: multiply them by 0.001 (unit_m: 0.001 of "
             "the reader, if it has that option)");
    else if (poses != 1)
        tell(findings, "pose_unit",
             "the poses' positions are not in the mesh's unit: multiply them by " + number(poses) +
                 " (multiply unit_m of scan.recording by it)");
    if (depths == 0.001)
        tell(findings, "millimeter_depth",
             "depths come out 1000 times too large: the depth pictures hold millimeters, set depth_unit_m: 0.001");
    else if (depths != 1 && extent == 0)
        tell(findings, "depth_unit",
             "the depths and the poses' positions are in different units: multiply " + depth_unit_by(depths) +
                 " or, if the depths are in meters, the positions by " + number(1 / depths) + " (unit_m of scan.recording)");
    else if (depths != 1)
        tell(findings, "depth_unit",
             "depths are not in the mesh's unit: multiply " + depth_unit_by(depths) +
                 "; or, if mesh and poses have an arbitrary unit, as COLMAP's have, multiply unit_m of both by " +
                 number(1 / depths));
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

std::string how_to_resize(double factor)
{
    return " are those of pictures " + number(1 / factor) + " times as large: multiply fx, fy, cx and cy by " + number(factor);
}

std::string edge_figures(double before, double after)
{
    return " (edges along the outlines are " + number(1 + after) + " times as strong as elsewhere then, " + number(1 + before) +
           " times as recorded)";
}

}  // namespace

std::string summary(const Diagnosis& diagnosis, bool by_mesh)
{
    const Fit& fit = diagnosis.recorded;
    std::string text;
    if (diagnosis.depths > 0)
        text = (by_mesh ? "the mesh covers " : "other frames see ") + percent(fit.covered_share) + " of the depths; " +
               percent(fit.agreement) +
               (by_mesh ? " of these agree with it (median difference " : " of these agree (median difference ") +
               number(100 * fit.median_error) + " %)";
    if (diagnosis.outline_points > 0)
        text += std::string(text.empty() ? "" : ", ") + "the pictures' edges are " + number(1 + fit.edge_response) +
                " times as strong along the outlines as elsewhere";
    if (text.empty())
        return std::string("nothing to compare: the frames have ") +
               (std::ranges::any_of(diagnosis.findings, [](const Finding& each) { return each.cause == "empty_depth"; }) ? "empty"
                                                                                                                         : "no") +
               " depth pictures, and no pictures in which the mesh has an outline";
    const std::string agree = by_mesh ? "mesh and frames agree: " : "the frames agree with each other: ";
    return (diagnosis.findings.empty() ? agree : "as recorded: ") + text;
}

double mesh_extent(const Mesh& mesh)
{
    numerics::Bounds<float> box;
    for (const Vec3f p : mesh.positions)
        box.add(p);
    return static_cast<double>(length(box.high - box.low));
}

void tell_assumption(const Diagnosis& diagnosis, double extent, bool one_camera, Findings& findings)
{
    const Assumption& a = diagnosis.assumption;
    tell_reading(a, extent, findings);
    tell_axes(a, extent, diagnosis.front_share < 0.5, findings);
    tell_units(a, extent, findings);
    if (a.along_ray)
        tell(findings, "ray_depth",
             "the depth pictures hold distances from the camera where depth along its axis is expected: divide each by the "
             "length of its pixel's ray ((x - cx) / fx, (y - cy) / fy, 1)");
    if (a.upside_down)
        tell(findings, "depth_upside_down",
             "the depth pictures are turned by 180 degrees: turn them or, if the color pictures are turned, too, the poses' "
             "cameras about their axes");
    if (a.by_color_camera)
        tell(findings, "depth_by_color_camera",
             "the depth pictures fit the color camera, not the depth camera: they are registered to color; use the color "
             "camera's intrinsics and pose for them");
    if (a.size_scale != 1)
        tell(findings, "depth_camera_size", "the depth camera's intrinsics" + how_to_resize(a.size_scale));
    if (a.focal_scale != 1 && one_camera)
        tell(findings, "depth_taken_for_color",
             "both cameras have the same intrinsics, which do not fit the depth pictures; the depth camera's focal length is " +
                 number(a.focal_scale) + " times as large");
    else if (a.focal_scale != 1)
        tell(findings, "depth_focal_length",
             "the focal length of the depth camera is " + how_to_mend(a.focal_scale, focal_reach));
}

void tell_color_focal(double mending, double before, double after, Findings& findings)
{
    tell(findings, "color_focal_length",
         "the focal length of the color camera is " + how_to_mend(mending, color_focal_reach) + edge_figures(before, after));
}

void tell_figures(const Diagnosis& diagnosis, Findings& findings)
{
    const std::size_t all = findings.size();
    for (std::size_t i = 0; i < all; ++i)
        if (diagnosis.depths == 0)
            findings[i].text += edge_figures(diagnosis.recorded.edge_response, diagnosis.explained.edge_response);
        else if (i + 1 < all)
            findings[i].text += fmt::format(" ({} of {} corrections that belong together)", i + 1, all);
        else
            findings[i].text += (all > 1 ? " (with all " + std::to_string(all) + " corrections together, " : " (") +
                                percent(diagnosis.explained.agreement) + " of the covered depths agree" +
                                (all > 1 ? ", " : " then, ") + percent(diagnosis.recorded.agreement) + " as recorded)";
}

void tell_inside_out(Findings& findings)
{
    tell(findings, "faces_inside_out",
         "the mesh is inside out: cameras see the backs of its faces; swap two corners of every face");
}

void tell_uncovered(bool by_mesh, Findings& findings)
{
    tell(findings, "uncovered",
         by_mesh ? "no inspected frame sees the mesh, and no usual mistake explains it: do mesh and frames belong together?"
                 : "no inspected frame sees what another one does, and no usual mistake explains it: are the poses in order?",
         false);
}

void tell_equal_poses(bool positions, bool rotations, Findings& findings)
{
    tell(findings, "equal_poses",
         std::string("all inspected frames have the same ") +
             (!positions   ? "rotation"
              : !rotations ? "position"
                           : "pose") +
             ", but their depth pictures or edges contradict that: export the recording with its poses");
}

void tell_disagreement(const Fit& fit, bool by_mesh, bool certain, Findings& findings)
{
    if (!by_mesh)
    {
        const std::string views = percent(fit.agreement) + " of the depths agree with those of other frames; " +
                                  percent(fit.in_front) + " are seen through";
        return tell(findings, certain ? "unexplained" : "agree_in_part",
                    certain ? "the frames contradict each other: " + views + ", and no usual mistake explains it"
                            : "the frames agree in part: " + views +
                                  ". No usual mistake explains it: see the picture that scan.inspect draws",
                    certain);
    }
    const std::string figures = "where the mesh is, " + percent(fit.agreement) +
                                " of the depths agree with it; it lies in front of " + percent(fit.in_front) +
                                " of the measured surface and behind " + percent(fit.behind);
    if (certain)
        tell(findings, "unexplained", figures + ", and no usual mistake explains it: check that mesh and frames belong together");
    else if (fit.behind > 4 * fit.in_front)
        tell(findings, "incomplete_mesh", figures + ": does it lack what stands there? Otherwise, check its unit", false);
    else
        tell(findings, "agree_in_part",
             "mesh and frames agree in part: " + figures +
                 ". No usual mistake explains it: see the picture that scan.inspect draws",
             false);
}

}  // namespace fresco::inspect

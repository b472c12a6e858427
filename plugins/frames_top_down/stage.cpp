#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/geometry/upright.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

using namespace fresco;

namespace
{

/// Of the mesh along a direction.
struct Extent
{
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    double length() const { return high - low; }
    double middle() const { return (low + high) / 2; }
};

Extent extent(const Mesh& mesh, Vec3d direction)
{
    Extent result;
    for (const Triangle& face : mesh.triangles)
        for (const auto vertex : face)
        {
            const double at = dot(vec_cast<double>(mesh.positions[vertex]), direction);
            result.low = std::min(result.low, at);
            result.high = std::max(result.high, at);
        }
    return result;
}

/// The level direction along the longer side of the smallest rectangle around the mesh's plan, to a degree.
Vec3d longer_side(const Mesh& mesh, Vec3d up)
{
    const Vec3d first = normalized(cross(up, std::abs(up.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
    const Vec3d second = cross(up, first);
    Vec3d longer = first;
    double least = std::numeric_limits<double>::infinity();
    for (int degrees = 0; degrees < 90; ++degrees)
    {
        const double angle = degrees * std::numbers::pi / 180;
        const Vec3d along = first * std::cos(angle) + second * std::sin(angle);
        const Vec3d across = cross(up, along);
        const double length = extent(mesh, along).length();
        const double width = extent(mesh, across).length();
        if (length * width >= least)
            continue;
        least = length * width;
        longer = length >= width ? along : across;
    }
    return longer;
}

class FramesTopDown final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The room"};
    Input<Frames> frames{this, "frames", optional, "Recorded frames, which say which way is up; not wired: the mesh says"};
    Output<Frames> above{this, "frames", "One frame, overview/top_down, without a picture"};
    Option<std::string> up = geometry::up_option(this);
    Option<int> height_px{this, "height_px", 1080, range(16, 8192),
                          "Height of its camera's picture; the width follows from the mesh"};
    Option<double> view_deg{this, "view_deg", 30, range(1, 120), "Angle of view across the shorter side; small: from far away"};

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        const Vec3d upward = geometry::shown_up(*up, *mesh, frames, run);
        const Vec3d right = longer_side(*mesh, upward);
        const Vec3d down = cross(right, upward);  // of the picture
        const Extent across = extent(*mesh, right);
        const Extent along = extent(*mesh, down);
        const Extent height = extent(*mesh, upward);

        constexpr double margin = 1.04;
        const double focal = *height_px / 2.0 / std::tan(*view_deg * std::numbers::pi / 360);
        const double shorter_m = margin * std::max(along.length(), 1e-3);
        const int width =
            std::max(1, static_cast<int>(std::lround(*height_px * std::min(margin * across.length() / shorter_m, 8.0))));
        // Everything lies below the top, where the least is seen.
        const double distance_m = std::max(shorter_m / *height_px, margin * across.length() / width) * focal;

        Frame frame;
        frame.sequence = "overview";
        frame.name = "top_down";
        frame.color.intrinsics = {width, *height_px, focal, focal, width / 2.0, *height_px / 2.0};
        frame.color.world_from_camera.rotation = {
            {right.x, down.x, -upward.x, right.y, down.y, -upward.y, right.z, down.z, -upward.z}};
        frame.color.world_from_camera.translation =
            right * across.middle() + down * along.middle() + upward * (height.high + distance_m);
        frame.depth = frame.color;
        Frames result;
        result.frames.push_back(frame);
        above = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("frames.top_down", FramesTopDown, "One frame that looks down on the whole mesh from above")

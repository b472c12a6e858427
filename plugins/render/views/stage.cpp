#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/geometry/upright.h>
#include <fresco/image_io.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <vector>

using namespace fresco;

namespace
{
/// The range of a mesh's vertices along a direction.
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

/// A frame whose color camera sees the whole mesh from where `outward` points, from as far as it must; 30 degrees wide across the
/// shorter side of the picture. `right`: in the picture.
Frame seen_from(const Mesh& mesh, Vec3d outward, Vec3d right, int height_px)
{
    constexpr double margin = 1.04;
    constexpr double view_angle = std::numbers::pi / 6;
    constexpr double widest = 8;  // Times the height.
    const Vec3d down = cross(right, outward);
    const Extent across = extent(mesh, right);
    const Extent along = extent(mesh, down);
    const double focal = height_px / 2.0 / std::tan(view_angle / 2);
    const double shorter_m = margin * std::max(along.length(), 1e-3);
    const int width =
        std::max(1, static_cast<int>(std::lround(height_px * std::min(margin * across.length() / shorter_m, widest))));
    // Everything lies behind the nearest point, where the camera sees least.
    const double distance_m = std::max(shorter_m / height_px, margin * across.length() / width) * focal;

    Frame frame;
    frame.color.intrinsics = {width, height_px, focal, focal, width / 2.0, height_px / 2.0};
    frame.color.world_from_camera.rotation = {
        {right.x, down.x, -outward.x, right.y, down.y, -outward.y, right.z, down.z, -outward.z}};
    frame.color.world_from_camera.translation =
        right * across.middle() + down * along.middle() + outward * (extent(mesh, outward).high + distance_m);
    return frame;
}

/// From above, with the longer side across; or else from four sides, from above the corners.
std::vector<Frame> seen_from_outside(const Mesh& mesh, Vec3d upward, bool above, int height_px)
{
    constexpr double elevation = std::numbers::pi / 5;
    const Vec3d first = longer_side(mesh, upward);
    std::vector<Frame> frames;
    for (int side = 0; side < (above ? 1 : 4); ++side)
    {
        const double angle = (side + 0.4) * std::numbers::pi / 2;
        const Vec3d level = first * std::cos(angle) + cross(upward, first) * std::sin(angle);
        const Vec3d outward = level * std::cos(elevation) + upward * std::sin(elevation);
        frames.push_back(above ? seen_from(mesh, upward, first, height_px)
                               : seen_from(mesh, outward, cross(upward, level), height_px));
        frames.back().sequence = above ? "above" : "side";
        frames.back().name = above ? "room" : std::to_string(side + 1);
    }
    return frames;
}

class RenderViews final : public Stage
{
    Input<TexturedMesh> mesh{this, "mesh", "The mesh with its picture, as texture.bake makes it"};
    Input<Frames> frames{this, "frames", optional,
                         "The views; their color cameras are used, not their pictures. Without: four views from outside, above "
                         "the corners, through walls that face away"};
    Output<Files> views{this, "views", "One RGBA PNG per view: <folder>/<sequence>_<frame>.png; alpha 0: no surface"};
    Option<OutputName> folder{this, "folder", OutputName{"views"}, "Folder of the pictures, below --out"};
    Option<int> height_px{this, "height_px", 0, range(0, 8192),
                          "Height of the pictures, the width follows; 0: the camera's own size, 1080 from outside"};
    Option<int> every_count{this, "every_count", 1, range(1, 1'000'000), "Render every n-th frame"};
    Option<int> samples{this, "samples", 2, range(1, 8),
                        "Samples per pixel along each side, against aliasing at edges and far away"};
    Choice<rendering::TextureFilter> filter = rendering::filter_option(this);
    Option<std::string> shading = rendering::shading_option(this);
    Option<bool> above{this, "above", false,
                       "Show the room as a doll's house, from above and through its ceiling, not the frames' views"};
    Option<std::string> up = geometry::up_option(this);
    Slot<ImageIo> images{this, "Encodes the pictures"};

    static constexpr int height_outside_px = 1080;

    Camera camera_of(const Frame& frame) const
    {
        Camera camera = frame.color;
        if (*height_px > 0)
            camera.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width_at(*height_px), *height_px);
        return camera;
    }

    std::vector<const Frame*> chosen() const
    {
        std::vector<const Frame*> result;
        std::set<std::string> names;
        for (std::size_t i = 0; i < frames->frames.size(); i += static_cast<std::size_t>(*every_count))
        {
            const Frame& frame = frames->frames[i];
            if (!names.insert(frame.sequence + "_" + frame.name).second)
                throw Error("two frames would be written as " + frame.sequence + "_" + frame.name +
                            ".png: rename the scan's sequences so that they differ");
            result.push_back(&frame);
        }
        return result;
    }

    void run(RunContext& run) override
    {
        if (frames.has_value())
            check_viewed(mesh->mesh, *frames, "what texture.bake made");
        const bool outside = *above || !frames.has_value();
        std::vector<Frame> planned;
        if (outside)
            planned = seen_from_outside(mesh->mesh, geometry::shown_up(*up, mesh->mesh, frames, run), *above,
                                        *height_px > 0 ? *height_px : height_outside_px);
        std::vector<const Frame*> list = outside ? std::vector<const Frame*>{} : chosen();
        for (const Frame& frame : planned)
            list.push_back(&frame);
        const rendering::ViewRenderer renderer(*mesh, {.samples_per_side = *samples,
                                                       .filter = *filter,
                                                       .lights = rendering::lights_of(*shading),
                                                       .through_backs = outside});
        std::filesystem::create_directories(views.folder().path / folder->path);
        Files result;
        std::vector<Camera> cameras;
        for (const Frame* frame : list)
        {
            cameras.push_back(camera_of(*frame));
            result.names.push_back(folder->path + "/" + frame->sequence + "_" + frame->name + ".png");
        }
        std::atomic<std::size_t> empty = 0;
        renderer.render_each(cameras, run,
                             [&](std::size_t i, const Raster8& image)
                             {
                                 bool any = false;
                                 for (std::size_t a = 3; a < image.values.size(); a += 4)
                                     any = any || image.values[a] > 0;
                                 empty += any ? 0 : 1;
                                 write_file(views.folder().path / result.names[i], images->encode_png(image));
                             });
        run.report("views", list.size());
        run.report("empty_views", empty.load());
        if (empty > 0)
            run.warning(fmt::format("{} of {} views show no surface", empty.load(), list.size()));
        views = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("render.views", RenderViews, "Renders the textured mesh from the frames' color cameras, or from outside")

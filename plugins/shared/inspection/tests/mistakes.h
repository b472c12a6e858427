#pragma once

#include <fresco/inspection/agreement.h>
#include <fresco/inspection/views.h>
#include <fresco/numerics/numerics.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

/// \file Mistakes made on purpose in a recording, and recordings that are right but look odd.

namespace mistakes
{

using namespace fresco;
using namespace fresco::inspect;

/// The inspected recording, which a mistake changes.
struct Looked
{
    Mesh mesh;  ///< Empty: views are compared with each other.
    std::vector<View> views;
    const Mesh* scanned = nullptr;  ///< The mesh before anything was changed.
};

using Change = std::function<void(Looked&)>;

inline Change both(const Change& first, const Change& second)
{
    return [=](Looked& looked)
    {
        first(looked);
        second(looked);
    };
}

inline Mat3 diagonal(double x, double y, double z)
{
    Mat3 m;
    m.m = {x, 0, 0, 0, y, 0, 0, 0, z};
    return m;
}

inline Change on_views(const std::function<void(View&)>& change)
{
    return [change](Looked& looked) { std::ranges::for_each(looked.views, change); };
}

/// Changes the poses of the depth camera; the color camera is fixed to it.
inline Change on_poses(const std::function<void(RigidTransform&)>& change)
{
    return on_views([change](View& view) { change(view.depth.pose); });
}

inline void opengl(RigidTransform& pose)
{
    pose.rotation = pose.rotation * diagonal(1, -1, -1);
}

inline Change scaled_poses(double scale)
{
    return on_poses([scale](RigidTransform& pose) { pose.translation = pose.translation * scale; });
}

inline Change read_as(Reading reading)
{
    return on_poses([reading](RigidTransform& pose) { pose = meant(pose, reading); });
}

inline Change on_mesh(const std::function<Vec3f(Vec3f)>& change)
{
    return [change](Looked& looked) { std::ranges::transform(looked.mesh.positions, looked.mesh.positions.begin(), change); };
}

inline Change scaled_mesh(float scale)
{
    return on_mesh([scale](Vec3f p) { return p * scale; });
}

inline void turn_faces(Looked& looked)
{
    for (Triangle& t : looked.mesh.triangles)
        std::swap(t[1], t[2]);
}

inline Change on_depths(const std::function<void(View&, DepthSample&)>& change)
{
    return on_views(
        [change](View& view)
        {
            for (auto* samples : {&view.depth.samples, &view.silhouette})
                for (DepthSample& sample : *samples)
                    change(view, sample);
        });
}

inline Change scaled_depths(float scale)
{
    return on_depths([scale](View&, DepthSample& sample) { sample.depth *= scale; });
}

inline void measure_along_rays(View& view, DepthSample& sample)
{
    const DepthSample unit{sample.x, sample.y, 1};
    sample.depth *= static_cast<float>(length(measured_ray(view.depth, unit, {}).direction));
}

inline void turn_depth(View& view, DepthSample& sample)
{
    sample.x = static_cast<float>(view.depth.depth.width) - sample.x;
    sample.y = static_cast<float>(view.depth.depth.height) - sample.y;
}

inline void turn_color(View& view)
{
    std::ranges::reverse(view.edges.values);
    for (Vec2f& pixel : view.pixels)
        pixel = Vec2f{static_cast<float>(view.color.width), static_cast<float>(view.color.height)} - pixel;
}

inline Change intrinsics(double color_size, double depth_size, double color_focal = 1, double depth_focal = 1)
{
    return on_views(
        [=](View& view)
        {
            view.depth.depth = scaled(view.depth.depth, depth_size, depth_focal);
            view.depth.color = scaled(view.depth.color, color_size, color_focal);
            view.color = scaled(view.color, color_size, color_focal);
        });
}

inline void set_color_camera(View& view, const Intrinsics& k)
{
    view.depth.color = k.scaled_to(view.depth.color.width, view.depth.color.height);
    view.color = k.scaled_to(view.color.width, view.color.height);
}

inline void color_as_depth(View& view)
{
    set_color_camera(view, view.depth.depth);
    view.depth.depth_from_color = {};
}

inline void move_depth_to_color(View& view)
{
    view.depth.pose = view.depth.pose * view.depth.depth_from_color;
    view.depth.depth = view.depth.color.scaled_to(view.depth.depth.width, view.depth.depth.height);
}

inline void depth_as_color(View& view)
{
    move_depth_to_color(view);
    view.depth.depth_from_color = {};
}

inline void swap_cameras(View& view)
{
    const Intrinsics depth = view.depth.depth;
    move_depth_to_color(view);
    set_color_camera(view, depth);
    view.depth.depth_from_color = view.depth.depth_from_color.inverse();
}

/// Depth as the color cameras would measure it, still said to be the depth cameras'.
inline void register_depth(Looked& looked)
{
    const raycast::Scene scene(*looked.scanned);
    for (View& view : looked.views)
    {
        const Intrinsics& size = view.depth.depth;
        const Camera camera{view.depth.color.scaled_to(size.width, size.height), view.depth.pose * view.depth.depth_from_color};
        const RasterF depth = mesh_depth(scene, camera, testing::TestRun(2));
        view.depth.samples = sample_depth(depth, 40);
        view.silhouette = silhouette(depth);
    }
}

/// Depth registered to color, and said to be.
inline Change one_camera_recording()
{
    return both(register_depth, on_views(depth_as_color));
}

inline void drop_depth(View& view)
{
    depth_as_color(view);
    view.depth.depth = view.depth.color;
    view.depth.samples.clear();
    view.silhouette.clear();
}

inline void drop_color(View& view)
{
    view.edges = {};
    view.pixels.clear();
}

/// Keeps the faces for which `keep(center)` holds.
inline Change keep_faces(const std::function<bool(Vec3f)>& keep)
{
    return [keep](Looked& looked)
    {
        Mesh& mesh = looked.mesh;
        std::erase_if(mesh.triangles, [&](const Triangle& t)
                      { return !keep((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) * (1.0F / 3)); });
    };
}

/// Faces within a box given in shares of the mesh's own.
inline Change crop(Vec3f low, Vec3f high)
{
    return [=](Looked& looked)
    {
        numerics::Bounds<float> box;
        for (const Vec3f p : looked.mesh.positions)
            box.add(p);
        const Vec3f size = box.high - box.low;
        const auto within = [](float at, float from, float to) { return at >= from && at <= to; };
        keep_faces(
            [=](Vec3f center)
            {
                const Vec3f p = center - box.low;
                return within(p.x, low.x * size.x, high.x * size.x) && within(p.y, low.y * size.y, high.y * size.y) &&
                       within(p.z, low.z * size.z, high.z * size.z);
            })(looked);
    };
}

/// One percent of noise.
inline void add_depth_noise(Looked& looked)
{
    Random random(3);
    on_depths([&](View&, DepthSample& sample) { sample.depth *= 1 + 0.01F * static_cast<float>(random.normal()); })(looked);
}

/// Poses that drift by a centimeter and 5 mrad, each on its own.
inline void add_pose_noise(Looked& looked)
{
    Random random(11);
    for (View& view : looked.views)
    {
        const RigidTransform off{numerics::rotation_by({0, 0.005 * random.normal(), 0}),
                                 Vec3d{random.normal(), random.normal(), random.normal()} * 0.01};
        view.depth.pose = view.depth.pose * off;
    }
}

inline Change keep_views(std::size_t count)
{
    return [=](Looked& looked) { looked.views.resize(std::min(count, looked.views.size())); };
}

inline Change keep_depths(const std::function<bool(const View&, const DepthSample&)>& keep)
{
    return on_views(
        [keep](View& view)
        {
            for (auto* samples : {&view.depth.samples, &view.silhouette})
                std::erase_if(*samples, [&](const DepthSample& sample) { return !keep(view, sample); });
        });
}

/// A board of half a meter by a half that hangs before the first camera: it was carried off before the frames were taken.
inline void add_board(Looked& looked)
{
    const RigidTransform& pose = looked.views.front().depth.pose;
    const auto at = [&](double x, double y) { return vec_cast<float>(pose.point({x, y, 1})); };
    const Vec3f corner = at(-0.25, -0.25);
    Mesh board = testing::rectangle(corner, at(0.25, -0.25) - corner, at(-0.25, 0.25) - corner);
    board.colors.assign(looked.mesh.colors.empty() ? 0 : 4, {90, 60, 30});
    testing::append(looked.mesh, board);
}

struct Case
{
    std::string name;
    Change change;
    std::vector<std::string> causes{};  ///< Expected causes: no others, in this order.
};

/// Every mistake that has a name.
inline std::vector<Case> named()
{
    const auto turned = [](Vec3f p) { return Vec3f{p.x, p.z, -p.y}; };
    const auto mirrored = [](Vec3f p) { return Vec3f{-p.x, p.y, p.z}; };
    const auto other_axes = [](RigidTransform& pose) { pose.rotation = pose.rotation * axis_rotations()[9]; };
    const auto gl = on_poses(opengl);
    const auto depth_turned = on_depths(turn_depth);
    return {{"OpenGL axes", gl, {"opengl_axes"}},
            {"inverted poses with OpenGL axes", both(gl, read_as(Reading::inverted)), {"inverted_poses", "opengl_axes"}},
            {"other camera axes", on_poses(other_axes), {"camera_axes"}},
            {"transposed rotations", read_as(Reading::transposed), {"transposed_rotations"}},
            {"quaternions w x y z taken for x y z w", read_as(Reading::scalar_last), {"quaternion_order"}},
            {"COLMAP's quaternions as x y z w", read_as(Reading::inverted_scalar_last), {"quaternion_order"}},
            {"poses in millimeters", scaled_poses(1000), {"millimeter_poses"}},
            {"poses in feet", scaled_poses(3.2808), {"pose_unit"}},
            {"poses with OpenGL axes in any unit", both(gl, scaled_poses(7.4)), {"opengl_axes", "pose_unit"}},
            {"a mesh in millimeters", scaled_mesh(1000), {"millimeter_mesh"}},
            {"a mesh in any unit", scaled_mesh(0.37F), {"mesh_unit"}},
            {"mesh and poses in millimeters", both(scaled_mesh(1000), scaled_poses(1000)), {"millimeter_world"}},
            {"mesh and poses in COLMAP's unit", both(scaled_mesh(1.9F), scaled_poses(1.9)), {"depth_unit"}},
            {"millimeters of depth taken for meters", scaled_depths(1000), {"millimeter_depth"}},
            {"a world turned", on_mesh(turned), {"world_axes"}},
            {"a mirrored mesh", on_mesh(mirrored), {"mirrored_mesh"}},
            {"inside out", turn_faces, {"faces_inside_out"}},
            {"distances along rays", on_depths(measure_along_rays), {"ray_depth"}},
            {"upside down", both(depth_turned, on_views(turn_color)), {"depth_upside_down"}},
            {"depth upside down", depth_turned, {"depth_upside_down"}},
            {"intrinsics of pictures twice the size", intrinsics(2, 2), {"depth_camera_size"}},
            {"the depth camera's half the size", intrinsics(1, 0.5), {"depth_camera_size"}},
            {"depth taken for color", on_views(depth_as_color), {"depth_taken_for_color"}},
            {"cameras swapped", on_views(swap_cameras), {"depth_by_color_camera"}},
            {"depth's focal length 10 % too small", intrinsics(1, 1, 1, 0.9), {"depth_focal_length"}},
            {"both focal lengths 10 % too large", intrinsics(1, 1, 1.1, 1.1), {"depth_focal_length", "color_focal_length"}},
            {"OpenGL axes and a focal length", both(gl, intrinsics(1, 1, 1, 1.1)), {"opengl_axes", "depth_focal_length"}},
            {"depth registered to color", register_depth, {"depth_by_color_camera"}}};
}

/// Mistakes that pictures show without depth.
inline std::vector<Case> named_by_edges()
{
    const auto no_depth = on_views(drop_depth);
    return {{"no depth, OpenGL axes", both(no_depth, on_poses(opengl)), {"opengl_axes"}},
            {"no depth, poses in millimeters", both(no_depth, scaled_poses(1000)), {"millimeter_poses"}},
            {"no depth, a mesh in millimeters", both(no_depth, scaled_mesh(1000)), {"millimeter_mesh"}}};
}

/// Mistakes of the color camera, of which only edges tell.
inline std::vector<Case> of_color()
{
    const std::vector<std::string> warned{"unexplained_edges"};
    return {{"color upside down", on_views(turn_color), warned},
            {"no depth, upside down", both(on_views(drop_depth), on_views(turn_color)), warned},
            {"the color camera's for 1.5 times the size", intrinsics(1.5, 1), warned},
            {"the color camera's for twice the size", intrinsics(2, 1), warned},
            {"the color camera's for half the size", intrinsics(0.5, 1), warned},
            {"color taken for depth", on_views(color_as_depth), {"color_focal_length"}},
            {"color's focal length 10 % too small", intrinsics(1, 1, 0.9, 1), {"color_focal_length"}}};
}

/// One name for causes that only a mesh tells apart: a unit of poses, depths or both; a focal length or a size.
inline std::string family(const std::string& cause)
{
    const auto has = [&](const char* part) { return cause.find(part) != std::string::npos; };
    if (has("unit") || has("millimeter"))
        return "unit";
    if (has("focal") || has("camera_size") || has("taken_for") || has("by_color_camera"))
        return "camera";
    return has("upside_down") ? "upside_down" : cause;
}

/// Named mistakes that change how depths of several frames agree, with one camera or two.
inline std::vector<Case> named_without_mesh()
{
    std::vector<Case> cases;
    for (Case& one : named())
    {
        const auto says = [&](const char* word)
        { return one.name.find(word) != std::string::npos || one.causes.front().find(word) != std::string::npos; };
        if (!says("mesh") && !says("world") && !says("inside") && !says("color") && !says("swapped"))
            cases.push_back(std::move(one));
    }
    return cases;
}

/// Frames that are right, with or without a mesh.
inline std::vector<Case> right_frames()
{
    const auto on_the_left = [](const View& view, const DepthSample& sample)
    { return sample.x < 0.3F * static_cast<float>(view.depth.depth.width); };
    return {{"as recorded", [](Looked&) {}},
            {"1 % of noise", add_depth_noise},
            {"one frame", keep_views(1)},
            {"two frames", keep_views(2)},
            {"depth to 2 m", keep_depths([](const View&, const DepthSample& sample) { return sample.depth < 2; })},
            {"depth on the left only", keep_depths(on_the_left)},
            {"no pictures", on_views(drop_color)},
            {"focal lengths off by 1.5 %", intrinsics(1, 1, 1.015, 1.015)}};
}

/// Recordings with a mesh that are right.
inline std::vector<Case> right()
{
    std::vector<Case> all = right_frames();
    const Change left_half = crop({0, 0, 0}, {0.5F, 1, 1});
    const auto striped = [](Vec3f p) { return std::sin(3 * (p.x + p.y + p.z)) > -0.3F; };
    all.insert(all.end(), {{"the left half", left_half},
                           {"the floor", crop({0, 0, 0}, {1, 1, 0.1F})},
                           {"a small object", crop({0.4F, 0.35F, 0.2F}, {0.6F, 0.65F, 0.5F})},
                           {"large holes", keep_faces(striped)},
                           {"drifting poses", add_pose_noise},
                           {"three frames of a part", both(keep_views(3), left_half)},
                           {"no depth, the left half", both(on_views(drop_depth), left_half)},
                           {"a board that was carried off", add_board},
                           {"one camera, the left half", both(one_camera_recording(), left_half)}});
    return all;
}

}  // namespace mistakes

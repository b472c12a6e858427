#pragma once

#include "agreement.h"
#include "outline.h"
#include "views.h"

#include <fresco/random.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

/// \file What mistakes change of a recording.

namespace mistakes
{

using namespace fresco;
using namespace fresco::inspect;

/// What is looked at, and what a mistake changes of it.
struct Looked
{
    Mesh mesh;
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

/// Of the depth camera; the color camera is fixed to it.
inline Change on_poses(const std::function<void(RigidTransform&)>& change)
{
    return [change](Looked& looked)
    {
        for (View& view : looked.views)
            for (RigidTransform& pose : view.depth.track.poses)
                change(pose);
    };
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
    return [change](Looked& looked)
    {
        for (Vec3f& p : looked.mesh.positions)
            p = change(p);
    };
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
    return [change](Looked& looked)
    {
        for (View& view : looked.views)
            for (auto* samples : {&view.depth.samples, &view.silhouette})
                for (DepthSample& sample : *samples)
                    change(view, sample);
    };
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

inline void turn_depth(Looked& looked)
{
    on_depths(
        [](View& view, DepthSample& sample)
        {
            sample.x = static_cast<float>(view.depth.depth.width) - sample.x;
            sample.y = static_cast<float>(view.depth.depth.height) - sample.y;
        })(looked);
}

inline void turn_color(Looked& looked)
{
    for (View& view : looked.views)
    {
        std::ranges::reverse(view.edges.values);
        for (ColorSample& sample : view.colors)
        {
            sample.x = static_cast<float>(view.color.width) - sample.x;
            sample.y = static_cast<float>(view.color.height) - sample.y;
        }
    }
}

inline void exchange_channels(Looked& looked)
{
    for (View& view : looked.views)
        for (ColorSample& sample : view.colors)
            std::swap(sample.color[0], sample.color[2]);
}

inline Change intrinsics(double color_size, double depth_size, double color_focal = 1, double depth_focal = 1)
{
    return [=](Looked& looked)
    {
        for (View& view : looked.views)
        {
            view.depth.depth = scaled(view.depth.depth, depth_size, depth_focal);
            view.depth.color = scaled(view.depth.color, color_size, color_focal);
            view.color = scaled(view.color, color_size, color_focal);
        }
    };
}

inline void color_as_depth(Looked& looked)
{
    for (View& view : looked.views)
    {
        view.depth.color = view.depth.depth.scaled_to(view.depth.color.width, view.depth.color.height);
        view.color = view.depth.depth.scaled_to(view.color.width, view.color.height);
        view.depth.depth_from_color = {};
    }
}

inline void move_depth_to_color(View& view)
{
    for (RigidTransform& pose : view.depth.track.poses)
        pose = pose * view.depth.depth_from_color;
    view.depth.depth = view.depth.color.scaled_to(view.depth.depth.width, view.depth.depth.height);
}

inline void depth_as_color(Looked& looked)
{
    for (View& view : looked.views)
    {
        move_depth_to_color(view);
        view.depth.depth_from_color = {};
    }
}

inline void swap_cameras(Looked& looked)
{
    for (View& view : looked.views)
    {
        const Intrinsics depth = view.depth.depth;
        move_depth_to_color(view);
        view.depth.color = depth.scaled_to(view.depth.color.width, view.depth.color.height);
        view.color = depth.scaled_to(view.color.width, view.color.height);
        view.depth.depth_from_color = view.depth.depth_from_color.inverse();
    }
}

/// Depth as the color cameras would measure it, still said to be the depth cameras'.
inline void register_depth(Looked& looked)
{
    const raycast::Scene scene(*looked.scanned);
    for (View& view : looked.views)
    {
        const Camera camera{view.depth.color.scaled_to(160, 120),
                            view.depth.track.poses[view.depth.track.own] * view.depth.depth_from_color};
        const RasterF depth = mesh_depth(scene, camera, testing::TestRun(2));
        view.depth.samples = sample_depth(depth, 40);
        view.silhouette = silhouette(depth);
        for (auto* samples : {&view.depth.samples, &view.silhouette})
            for (DepthSample& sample : *samples)
            {
                sample.x *= static_cast<float>(view.depth.depth.width) / 160;
                sample.y *= static_cast<float>(view.depth.depth.height) / 120;
            }
    }
}

/// Each picture gets the pose so many frames before its own; between poses of the track.
inline Change late_poses(double frames)
{
    return [=](Looked& looked)
    {
        for (View& view : looked.views)
        {
            PoseTrack late = view.depth.track;
            for (std::size_t i = 0; i < late.poses.size(); ++i)
            {
                PoseTrack around = view.depth.track;
                around.own = i;
                Assumption lag;
                lag.lag_frames = -frames;
                late.poses[i] = lag.pose(around);
            }
            view.depth.track = late;
        }
    };
}

inline void rotate_pictures(Looked& looked)
{
    for (std::size_t i = 1; i < looked.views.size(); ++i)
    {
        std::swap(looked.views[i - 1].edges, looked.views[i].edges);
        std::swap(looked.views[i - 1].colors, looked.views[i].colors);
    }
}

inline void drop_depth(Looked& looked)
{
    for (View& view : looked.views)
    {
        for (RigidTransform& pose : view.depth.track.poses)
            pose = pose * view.depth.depth_from_color;
        view.depth.depth = view.depth.color;
        view.depth.depth_from_color = {};
        view.depth.samples.clear();
        view.silhouette.clear();
    }
}

inline void drop_color(Looked& looked)
{
    for (View& view : looked.views)
    {
        view.edges = {};
        view.colors.clear();
    }
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
        Vec3f least = looked.mesh.positions.front();
        Vec3f most = least;
        for (const Vec3f p : looked.mesh.positions)
        {
            least = {std::min(least.x, p.x), std::min(least.y, p.y), std::min(least.z, p.z)};
            most = {std::max(most.x, p.x), std::max(most.y, p.y), std::max(most.z, p.z)};
        }
        const Vec3f size = most - least;
        keep_faces(
            [=](Vec3f p)
            {
                return p.x >= least.x + low.x * size.x && p.x <= least.x + high.x * size.x && p.y >= least.y + low.y * size.y &&
                       p.y <= least.y + high.y * size.y && p.z >= least.z + low.z * size.z && p.z <= least.z + high.z * size.z;
            })(looked);
    };
}

/// Removes the faces within balls around some vertices.
inline Change holes(std::size_t count, float radius)
{
    return [=](Looked& looked)
    {
        Random random(7);
        std::vector<Vec3f> centers;
        for (std::size_t i = 0; i < count; ++i)
            centers.push_back(
                looked.mesh
                    .positions[static_cast<std::size_t>(random.below(static_cast<std::int64_t>(looked.mesh.positions.size())))]);
        keep_faces([&](Vec3f p)
                   { return std::ranges::none_of(centers, [&](Vec3f center) { return length(p - center) < radius; }); })(looked);
    };
}

inline Change depth_noise(double share, double meters)
{
    return [=](Looked& looked)
    {
        Random random(3);
        on_depths(
            [&](View&, DepthSample& sample) {
                sample.depth += static_cast<float>(random.normal() * (share * static_cast<double>(sample.depth) + meters));
            })(looked);
    };
}

inline Change mesh_noise(float meters)
{
    return [=](Looked& looked)
    {
        Random random(5);
        for (Vec3f& p : looked.mesh.positions)
            p += Vec3f{static_cast<float>(random.normal()), static_cast<float>(random.normal()),
                       static_cast<float>(random.normal())} *
                 meters;
    };
}

/// Drifting poses, each off on its own.
inline Change pose_noise(double meters, double radians)
{
    return [=](Looked& looked)
    {
        Random random(11);
        for (View& view : looked.views)
        {
            RigidTransform off;
            const double turn = radians * random.normal();
            off.rotation.m = {std::cos(turn), 0, std::sin(turn), 0, 1, 0, -std::sin(turn), 0, std::cos(turn)};
            off.translation = Vec3d{random.normal(), random.normal(), random.normal()} * meters;
            for (RigidTransform& pose : view.depth.track.poses)
                pose = pose * off;
        }
    };
}

inline Change keep_views(std::size_t count)
{
    return [=](Looked& looked) { looked.views.resize(std::min(count, looked.views.size())); };
}

inline Change keep_depths(const std::function<bool(const View&, const DepthSample&, double)>& keep)
{
    return [=](Looked& looked)
    {
        Random random(13);
        for (View& view : looked.views)
            for (auto* samples : {&view.depth.samples, &view.silhouette})
                std::erase_if(*samples, [&](const DepthSample& sample) { return !keep(view, sample, random.uniform()); });
    };
}

/// A board of half a meter by a half that hangs before the first camera: it was carried off before the frames were taken.
inline void add_board(Looked& looked)
{
    const RigidTransform& pose = looked.views.front().depth.track.poses[looked.views.front().depth.track.own];
    const auto first = static_cast<std::uint32_t>(looked.mesh.positions.size());
    for (const double y : {-0.25, 0.25})
        for (const double x : {-0.25, 0.25})
        {
            looked.mesh.positions.push_back(vec_cast<float>(pose.point({x, y, 1})));
            if (!looked.mesh.colors.empty())
                looked.mesh.colors.push_back({90, 60, 30});
        }
    looked.mesh.triangles.push_back({first, first + 1, first + 2});
    looked.mesh.triangles.push_back({first + 1, first + 3, first + 2});
}

inline Change moved_mesh(Vec3f by)
{
    return on_mesh([by](Vec3f p) { return p + by; });
}

}  // namespace mistakes

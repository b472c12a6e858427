#pragma once

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/raycast/scene.h>
#include <fresco/testing_scenes.h>

/// \file A room of few large faces, and rays against every one of them in turn: the slow twins' world.

namespace rooms
{

using namespace fresco;

/// 4 m x 3 m x 2.5 m, z up, with a cupboard of 1.2 m x 0.5 m x 1.8 m that stands 0.8 m before the wall x = 4; behind that wall
/// a closed space of 1 m x 3 m x 2.5 m.
inline Mesh room_with_cupboard()
{
    testing::ChartedMesh builder(4, 4.6F);  // 20 m along a side of the texture
    builder.box({0, 0, 0}, {4, 3, 2.5F}, false);
    builder.box({2.7F, 0.9F, 0.0F}, {0.5F, 1.2F, 1.8F}, true);
    builder.rectangle({5, 0, 0}, {0, 0, 2.5F}, {0, 3, 0});
    builder.mesh.texture_px = 256;
    return builder.mesh;
}

/// At (1, 1.5, 1.4), looking along +x, level: sees the cupboard's front, but nothing behind it.
inline Frame frame_before_cupboard()
{
    Camera camera = testing::camera(64, 48, 50, {1, 1.5, 1.4});
    camera.world_from_camera.rotation = {{0, 0, 1, -1, 0, 0, 0, -1, 0}};
    return testing::frame("frame-000000", camera);
}

/// Whether the eye sees the point of a face: the face's front, and nothing before it.
inline bool slow_sees(const Mesh& mesh, Vec3d eye, Vec3d point, std::uint32_t face)
{
    const Vec3d toward = point - eye;
    const auto c = raycast::corners(mesh, face);
    if (dot(cross(c[1] - c[0], c[2] - c[0]), toward) >= 0 || length(toward) < 0.05)
        return false;
    const auto hit = testing::cast(mesh, eye, toward);
    return hit.triangle == face || (hit.found() && hit.front && (1 - hit.distance) * length(toward) <= 1e-3);
}

}  // namespace rooms

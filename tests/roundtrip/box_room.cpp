#include "box_room.h"

#include <cmath>
#include <string>

using namespace fresco;

namespace
{
constexpr float texels_per_m = 8.5F;
constexpr int cell_px = 40;
constexpr float padding_px = 3;

/// Adds rectangles, each in the next cell of a grid of charts.
class RoomBuilder
{
  public:
    Mesh mesh;

    /// Seen from the side that along x up points to; u runs along `along`, v along `up`.
    void add(Vec3f corner, Vec3f along, Vec3f up)
    {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const Vec3f p : {corner, corner + along, corner + along + up, corner + up})
            mesh.positions.push_back(p);
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
        const int cells = box_room_texture_px / cell_px;
        const float u0 = static_cast<float>(next_cell_ % cells * cell_px) + padding_px;
        const float v0 = static_cast<float>(next_cell_ / cells * cell_px) + padding_px;
        const float u1 = u0 + length(along) * texels_per_m;
        const float v1 = v0 + length(up) * texels_per_m;
        const auto uv = [](float u, float v) { return Vec2f{u / box_room_texture_px, v / box_room_texture_px}; };
        for (const Vec2f t : {uv(u0, v0), uv(u1, v0), uv(u1, v1), uv(u0, v0), uv(u1, v1), uv(u0, v1)})
            mesh.texcoords.push_back(t);
        ++next_cell_;
    }

  private:
    int next_cell_ = 0;
};

RigidTransform looking_at(Vec3d eye, Vec3d target)
{
    const Vec3d forward = normalized(target - eye);
    const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1}));
    const Vec3d down = cross(forward, right);
    RigidTransform world_from_camera;
    world_from_camera.rotation.m = {right.x, down.x, forward.x, right.y, down.y, forward.y, right.z, down.z, forward.z};
    world_from_camera.translation = eye;
    return world_from_camera;
}
}  // namespace

Mesh box_room()
{
    RoomBuilder room;
    room.add({0, 0, 0}, {4, 0, 0}, {0, 3, 0});      // floor
    room.add({0, 3, 2.5F}, {4, 0, 0}, {0, -3, 0});  // ceiling
    room.add({0, 3, 0}, {4, 0, 0}, {0, 0, 2.5F});   // walls
    room.add({4, 0, 0}, {-4, 0, 0}, {0, 0, 2.5F});
    room.add({0, 0, 0}, {0, 3, 0}, {0, 0, 2.5F});
    room.add({4, 3, 0}, {0, -3, 0}, {0, 0, 2.5F});
    room.add({1.4F, 1.2F, 0.7F}, {1.2F, 0, 0}, {0, 0.8F, 0});  // the block's top and sides
    room.add({1.4F, 1.2F, 0}, {1.2F, 0, 0}, {0, 0, 0.7F});
    room.add({2.6F, 2.0F, 0}, {-1.2F, 0, 0}, {0, 0, 0.7F});
    room.add({1.4F, 2.0F, 0}, {0, -0.8F, 0}, {0, 0, 0.7F});
    room.add({2.6F, 1.2F, 0}, {0, 0.8F, 0}, {0, 0, 0.7F});
    return room.mesh;
}

Frames box_room_frames()
{
    const Vec3d eyes[] = {{0.4, 0.4, 1.6}, {3.6, 0.5, 1.5}, {3.5, 2.6, 1.7}, {0.5, 2.5, 1.4},
                          {2.0, 0.3, 2.2}, {2.2, 2.7, 1.0}, {0.3, 1.5, 1.2}, {3.7, 1.5, 0.9}};
    const Vec3d targets[] = {{2.2, 1.7, 0.5}, {1.5, 2.0, 0.8}, {1.2, 0.8, 0.9}, {3.0, 0.9, 1.1},
                             {2.1, 2.0, 0.2}, {1.8, 0.2, 1.9}, {3.9, 1.2, 1.9}, {0.1, 1.9, 1.6}};
    Frames frames;
    for (std::size_t i = 0; i < std::size(eyes); ++i)
    {
        Frame frame;
        frame.sequence = "seq-01";
        frame.name = "frame-" + std::to_string(i);
        frame.number = static_cast<long>(i);
        frame.color.intrinsics = {160, 120, 118, 121, 77.2, 62.9};
        frame.color.world_from_camera = looking_at(eyes[i], targets[i]);
        // Beside the color camera and turned a little outwards.
        const Vec3d right = frame.color.world_from_camera.direction({1, 0, 0});
        frame.depth.intrinsics = {128, 96, 88, 90, 65.5, 46.1};
        frame.depth.world_from_camera = looking_at(eyes[i] + right * 0.08, targets[i] + right * 0.2);
        frames.frames.push_back(frame);
    }
    return frames;
}

#pragma once

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/testing_scenes.h>

#include <cstddef>
#include <string>

/// A room of 4 x 3 x 2.5 m with a block in it, seen from inside; every side is a rectangular chart of its own, 8.5 texels per
/// meter in a picture of box_room_texture_px.
inline fresco::Mesh box_room()
{
    fresco::testing::ChartedMesh room(4, 4, 0.075F);
    room.rectangle({0, 0, 0}, {4, 0, 0}, {0, 3, 0});      // floor
    room.rectangle({0, 3, 2.5F}, {4, 0, 0}, {0, -3, 0});  // ceiling
    room.rectangle({0, 3, 0}, {4, 0, 0}, {0, 0, 2.5F});   // walls
    room.rectangle({4, 0, 0}, {-4, 0, 0}, {0, 0, 2.5F});
    room.rectangle({0, 0, 0}, {0, 3, 0}, {0, 0, 2.5F});
    room.rectangle({4, 3, 0}, {0, -3, 0}, {0, 0, 2.5F});
    room.rectangle({1.4F, 1.2F, 0.7F}, {1.2F, 0, 0}, {0, 0.8F, 0});  // the block's top and sides
    room.rectangle({1.4F, 1.2F, 0}, {1.2F, 0, 0}, {0, 0, 0.7F});
    room.rectangle({2.6F, 2.0F, 0}, {-1.2F, 0, 0}, {0, 0, 0.7F});
    room.rectangle({1.4F, 2.0F, 0}, {0, -0.8F, 0}, {0, 0, 0.7F});
    room.rectangle({2.6F, 1.2F, 0}, {0, 0.8F, 0}, {0, 0, 0.7F});
    return room.mesh;
}
inline constexpr int box_room_texture_px = 160;

/// Eight views whose color and depth cameras differ in size, intrinsics and pose.
inline fresco::Frames box_room_frames()
{
    using namespace fresco;
    const Vec3d eyes[] = {{0.4, 0.4, 1.6}, {3.6, 0.5, 1.5}, {3.5, 2.6, 1.7}, {0.5, 2.5, 1.4},
                          {2.0, 0.3, 2.2}, {2.2, 2.7, 1.0}, {0.3, 1.5, 1.2}, {3.7, 1.5, 0.9}};
    const Vec3d targets[] = {{2.2, 1.7, 0.5}, {1.5, 2.0, 0.8}, {1.2, 0.8, 0.9}, {3.0, 0.9, 1.1},
                             {2.1, 2.0, 0.2}, {1.8, 0.2, 1.9}, {3.9, 1.2, 1.9}, {0.1, 1.9, 1.6}};
    Frames frames;
    for (std::size_t i = 0; i < std::size(eyes); ++i)
    {
        const Camera color{{160, 120, 118, 121, 77.2, 62.9}, testing::looking_at(eyes[i], targets[i])};
        Frame frame = testing::frame("frame-" + std::to_string(i), color, static_cast<long>(i));
        // Beside the color camera and turned a little outwards.
        const Vec3d right = frame.color.world_from_camera.direction({1, 0, 0});
        frame.depth.intrinsics = {128, 96, 88, 90, 65.5, 46.1};
        frame.depth.world_from_camera = testing::looking_at(eyes[i] + right * 0.08, targets[i] + right * 0.2);
        frames.frames.push_back(frame);
    }
    return frames;
}

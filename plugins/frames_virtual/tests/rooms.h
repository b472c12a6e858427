#pragma once

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/raycast/scene.h>

#include <algorithm>

/// \file A room of few large faces, and rays against every one of them in turn: the slow twins' world.

namespace rooms
{

using namespace fresco;

/// A mesh of rectangles, each a chart of its own: 20 m along a side of the texture, in tiles of 5 m.
class Builder
{
  public:
    /// The rectangle from `corner` along `a` and `b`, seen from where cross(a, b) points to.
    void rectangle(Vec3f corner, Vec3f a, Vec3f b)
    {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        const Vec2f tile{0.25F * static_cast<float>(count_ % 4) + 0.01F, 0.25F * static_cast<float>(count_ / 4) + 0.01F};
        ++count_;
        const auto at = [&](float s, float t) { return tile + Vec2f{s * length(a) / 20, t * length(b) / 20}; };
        for (const auto& [s, t] : {std::pair(0.0F, 0.0F), {1.0F, 0.0F}, {1.0F, 1.0F}, {0.0F, 1.0F}})
            mesh.positions.push_back(corner + a * s + b * t);
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
        mesh.texcoords.insert(mesh.texcoords.end(), {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)});
    }

    /// The six sides of a box, seen from outside or from inside.
    void box(Vec3f least, Vec3f size, bool from_outside)
    {
        const Vec3f x{size.x, 0, 0};
        const Vec3f y{0, size.y, 0};
        const Vec3f z{0, 0, size.z};
        const auto side = [&](Vec3f corner, Vec3f a, Vec3f b)
        { from_outside ? rectangle(corner, a, b) : rectangle(corner, b, a); };
        side(least, y, x);
        side(least + z, x, y);
        side(least, x, z);
        side(least + y, z, x);
        side(least, z, y);
        side(least + x, y, z);
    }

    Mesh mesh;

  private:
    int count_ = 0;
};

/// 4 m x 3 m x 2.5 m, z up, with a cupboard of 1.2 m x 0.5 m x 1.8 m that stands 0.8 m before the wall x = 4; behind that wall
/// a closed space of 1 m x 3 m x 2.5 m.
inline Mesh room_with_cupboard()
{
    Builder builder;
    builder.box({0, 0, 0}, {4, 3, 2.5F}, false);
    builder.box({2.7F, 0.9F, 0.0F}, {0.5F, 1.2F, 1.8F}, true);
    builder.rectangle({5, 0, 0}, {0, 0, 2.5F}, {0, 3, 0});
    builder.mesh.texture_px = 256;
    return builder.mesh;
}

/// At (1, 1.5, 1.4), looking along +x, level: sees the cupboard's front, but nothing behind it.
inline Frame frame_before_cupboard()
{
    Frame frame;
    frame.sequence = "seq-01";
    frame.name = "frame-000000";
    frame.color.intrinsics = {64, 48, 50, 50, 32, 24};
    frame.color.world_from_camera = {{{0, 0, 1, -1, 0, 0, 0, -1, 0}}, {1, 1.5, 1.4}};
    frame.depth = frame.color;
    return frame;
}

/// Every triangle in turn. The distance is in lengths of the direction, as Scene's.
inline raycast::Hit slow_cast(const Mesh& mesh, Vec3d origin, Vec3d direction)
{
    raycast::Hit best;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    {
        double distance = 0;
        std::array<double, 3> w{};
        const auto c = raycast::corners(mesh, t);
        if (!raycast::meet_plane(c, origin, direction, distance, w) || distance < 0 || std::min({w[0], w[1], w[2]}) < 0)
            continue;
        if (best.found() && best.distance <= distance)
            continue;
        best.triangle = t;
        best.distance = distance;
        best.front = dot(cross(c[1] - c[0], c[2] - c[0]), direction) < 0;
    }
    return best;
}

/// Whether the eye sees the point of a face: the face's front, and nothing before it.
inline bool slow_sees(const Mesh& mesh, Vec3d eye, Vec3d point, std::uint32_t face)
{
    const Vec3d toward = point - eye;
    const auto c = raycast::corners(mesh, face);
    if (dot(cross(c[1] - c[0], c[2] - c[0]), toward) >= 0 || length(toward) < 0.05)
        return false;
    const auto hit = slow_cast(mesh, eye, toward);
    return hit.triangle == face || (hit.found() && hit.front && (1 - hit.distance) * length(toward) <= 1e-3);
}

}  // namespace rooms

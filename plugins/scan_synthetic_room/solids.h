#pragma once

#include <fresco/math.h>

#include <array>
#include <cstdint>
#include <numbers>

/// \file The analytic bodies that the room is made of; meters. One description serves pictures, depth and mesh.
namespace room
{

inline constexpr float pi = std::numbers::pi_v<float>;

using fresco::Vec2f;
using fresco::Vec3f;

enum class Shape : std::uint8_t
{
    box,       ///< size = half edges; faces -x, +x, -y, +y, -z, +z
    frustum,   ///< Round, along local z: size = radius at the bottom, radius at the top, half height; faces side, bottom, top
    ellipsoid  ///< size = radii; one face
};

/// What a body is part of: a rug of the floor, a beam of the ceiling, a door or picture of the walls.
enum class Part : std::uint8_t
{
    floor,
    ceiling,
    walls,
    furniture
};

struct Solid
{
    Shape shape = Shape::box;
    bool hollow = false;  ///< The room itself: a box seen from inside. Its faces are the floor, the ceiling and the walls.
    Part part = Part::furniture;
    Vec3f center;
    std::array<Vec3f, 3> axes{Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}};  ///< World directions of the local axes, unit.
    Vec3f size;
    std::array<std::uint16_t, 6> materials{};  ///< Index by face.

    int face_count() const { return shape == Shape::box ? 6 : shape == Shape::frustum ? 3 : 1; }
    Vec3f to_local(Vec3f world_direction) const
    {
        return {dot(axes[0], world_direction), dot(axes[1], world_direction), dot(axes[2], world_direction)};
    }
    Vec3f to_world(Vec3f local_direction) const
    {
        return axes[0] * local_direction.x + axes[1] * local_direction.y + axes[2] * local_direction.z;
    }
};

/// A ray in world coordinates; distances along it count in lengths of `direction`.
struct Ray
{
    Vec3f origin;
    Vec3f direction;
};

struct Hit
{
    float t = 0;
    int face = -1;  ///< -1: none.
};

/// First hit with 1e-4 < t < limit. A ray that starts inside hits the wall from within.
Hit intersect(const Solid& solid, const Ray& ray, float limit);

/// Signed distance of a world point, negative inside (for a hollow solid: outside of the room). Exact for boxes and frustums,
/// first order for ellipsoids.
float signed_distance(const Solid& solid, Vec3f world_point);

/// Half edges of the axis-aligned box around `center` that holds the solid.
Vec3f half_extent(const Solid& solid);

/// Meters along a face: u and v from 0 to face_extent. On sides u runs around.
Vec2f face_extent(const Solid& solid, int face);
Vec2f face_coordinates(const Solid& solid, int face, Vec3f world_point);

struct FacePoint
{
    Vec3f position;  ///< World.
    Vec3f normal;    ///< World, unit, toward free space.
};

FacePoint face_point(const Solid& solid, int face, Vec2f coordinates);

/// The face next to a world point near the surface.
int nearest_face(const Solid& solid, Vec3f world_point);

}  // namespace room

#pragma once

#include <fresco/math.h>
#include <fresco/numerics/numerics.h>

#include <array>
#include <cstdint>
#include <numbers>
#include <vector>

/// \file The generated room as analytic bodies with materials, and the rays that meet them; meters. One description serves
/// pictures, depth and mesh, so that they agree exactly. furnish() builds a scene; light, recording and mesh are made from it.

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

/// The part of the room that a body belongs to: rugs to the floor, beams to the ceiling, doors and pictures to the walls.
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

/// First hit with 1e-4 < t < limit. A ray that starts inside hits the surface from within.
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

enum class Pattern : std::uint8_t
{
    plaster,
    planks,
    brick,
    wallpaper,
    wood,
    fabric,
    rug,
    painting,
    book,
    leaf,
    ceramic,
    panels,
    basket,
    sky,
    shade
};

/// The look of a face. Colors are display sRGB, 0..1.
struct Material
{
    Pattern pattern = Pattern::plaster;
    Vec3f first;
    Vec3f second;
    float scale = 1;  ///< Meters per feature of the pattern.
    std::uint32_t seed = 0;
    float emission = 0;  ///< Radiant exitance of lamps and windows; 0: none.
};

struct Scene
{
    Vec3f size;                 ///< Inner edges of the room; the floor is z = 0, the corner (0, 0, 0).
    std::vector<Solid> solids;  ///< solids[0] is the hollow room.
    std::vector<Material> materials;

    const Material& material(int solid, int face) const
    {
        const auto& body = solids[static_cast<std::size_t>(solid)];
        return materials[body.materials[static_cast<std::size_t>(face)]];
    }
};

/// Free space around a point: positive in the air, negative inside furniture or beyond the walls.
float free_distance(const Scene& scene, Vec3f point);

struct SceneHit
{
    float t = 0;
    int solid = -1;  ///< -1: none.
    int face = 0;
    bool same_face(const SceneHit& other) const { return solid == other.solid && face == other.face; }
};

/// Finds the first hit of a ray by a tree of bounding boxes over the furniture, and the room around it. Immutable, so
/// thread-safe. The scene must outlive it.
class Caster
{
  public:
    explicit Caster(const Scene& scene);
    const Scene& scene() const { return *scene_; }
    /// A `guess`, the solid that a neighboring ray met, makes it faster; it changes the result only between faces in one plane.
    SceneHit cast(const Ray& ray, int guess = -1) const;
    /// Whether the ray meets a solid other than `ignored` (-1: any) before t = `limit`.
    bool blocked(const Ray& ray, float limit, int ignored) const;

  private:
    using Bounds = fresco::numerics::Bounds<float>;
    struct Node
    {
        Bounds box;
        int first = 0;  ///< Leaf: index into order_; else the left child, the right one follows.
        int count = 0;  ///< 0: inner node.
    };
    Bounds bounds(std::size_t begin, std::size_t end) const;
    void sort_along(int axis, std::size_t begin, std::size_t end);
    void build(std::size_t node, std::size_t begin, std::size_t end);

    const Scene* scene_;
    std::vector<Node> nodes_;
    std::vector<int> order_;
};

}  // namespace room

#include "clip.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace raster
{
namespace
{

using fresco::Vec3d;

/// The side on which normal . p >= offset is kept.
struct HalfSpace
{
    Vec3d normal;
    double offset;

    double inside(Vec3d p) const { return dot(normal, p) - offset; }
};

struct Polygon
{
    std::array<Vec3d, Clipped::most_corners> corners;
    std::size_t count = 0;

    void add(Vec3d corner) { corners[count++] = corner; }
};

bool before(Vec3d a, Vec3d b)
{
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// Where an edge meets the plane; the same for either direction of the edge.
Vec3d meeting(Vec3d a, Vec3d b, const HalfSpace& half)
{
    if (before(b, a))
        std::swap(a, b);
    const double at_a = half.inside(a);
    const double at_b = half.inside(b);
    return a + (b - a) * (at_a / (at_a - at_b));
}

Polygon cut(const Polygon& polygon, const HalfSpace& half)
{
    Polygon result;
    for (std::size_t i = 0; i < polygon.count; ++i)
    {
        const Vec3d from = polygon.corners[i];
        const Vec3d to = polygon.corners[(i + 1) % polygon.count];
        const bool from_inside = half.inside(from) >= 0;
        const bool to_inside = half.inside(to) >= 0;
        if (from_inside)
            result.add(from);
        if (from_inside != to_inside)
            result.add(meeting(from, to, half));
    }
    return result;
}

}  // namespace

Clipped clipped(const std::array<Vec3d, 3>& triangle, const Frustum& frustum)
{
    const auto& guard = frustum.guard;
    const std::array<HalfSpace, 5> halves{{{{0, 0, 1}, near_m},
                                           {{1, 0, -guard.left}, 0},
                                           {{-1, 0, guard.right}, 0},
                                           {{0, 1, -guard.above}, 0},
                                           {{0, -1, guard.below}, 0}}};
    Polygon polygon;
    for (const Vec3d corner : triangle)
        polygon.add(corner);
    for (const HalfSpace& half : halves)
        polygon = cut(polygon, half);
    Clipped result;
    for (std::size_t i = 0; i < polygon.count; ++i)
    {
        const Vec3d p = polygon.corners[i];
        const double nearness = 1 / std::max(p.z, near_m);
        // Corners cut from very far ones are known to few digits; beyond the guard they would overflow.
        const double x = std::min(std::max(p.x * nearness, guard.left), guard.right);
        const double y = std::min(std::max(p.y * nearness, guard.above), guard.below);
        result.corners[result.count++] = {x, y, static_cast<float>(nearness), 0};
    }
    return result;
}

}  // namespace raster

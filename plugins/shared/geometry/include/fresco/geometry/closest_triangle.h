#pragma once

#include <fresco/math.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace fresco::geometry
{

using Corners3 = std::array<Vec3d, 3>;

/// The point of a triangle that is closest to `point`. A triangle without area is the longest of its sides.
Vec3d closest_point(const Corners3& triangle, Vec3d point);

struct Closest
{
    std::size_t triangle = 0;
    Vec3d point;
    double distance = 0;
};

/// Finds the closest of many triangles (segments are triangles that name an end twice): a tree of boxes, split at the median.
/// Copies the triangles; immutable, any thread.
class ClosestTriangle
{
  public:
    /// At least one triangle; all coordinates finite.
    explicit ClosestTriangle(std::vector<Corners3> triangles);

    /// Of equally close triangles the first one met; `distance` is infinite where none is closer than `within`.
    Closest find(Vec3d point, double within = std::numeric_limits<double>::infinity()) const;

  private:
    struct Node
    {
        Vec3d low, high;
        std::uint32_t first = 0;  ///< Leaf: into order_; else the left child, the right one follows.
        std::uint32_t count = 0;  ///< 0: inner node.
    };
    void build(std::size_t node, std::size_t begin, std::size_t end);
    void search(std::size_t node, Vec3d point, Closest& best) const;

    std::vector<Corners3> triangles_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace fresco::geometry

#pragma once

#include <fresco/mesh.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

/// \file The nearest point of a mesh: how labels and colors go from one mesh to another, and how far two surfaces are apart.

namespace fresco::geometry
{

/// A point of a mesh's surface.
struct SurfacePoint
{
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    std::uint32_t face = none;
    std::array<double, 3> weights{};  ///< Weights of the face's corners; they add up to 1.
    double squared_distance = std::numeric_limits<double>::infinity();

    bool found() const { return face != none; }
};

/// The weights of the point of a triangle that is nearest to `p`; the triangle may be a segment or a point that names a
/// vertex again.
/// Ericson, "Real-Time Collision Detection" (2005), section 5.1.5.
std::array<double, 3> nearest_weights(const std::array<Vec3d, 3>& corners, Vec3d p);

/// Finds nearest surface points by a tree of boxes. Exact; safe to use from several threads.
class SurfaceSearch
{
  public:
    /// The mesh has faces, all coordinates are finite; it must outlive the search.
    explicit SurfaceSearch(const Mesh& mesh);

    /// The nearest point at most `reach` away; among equally near ones that of the lowest face.
    SurfacePoint nearest(Vec3d p, double reach = std::numeric_limits<double>::infinity()) const;

    /// Nearest point of the faces whose normal is less than 90 degrees from `normal`, so that the back of a thin wall does not
    /// count. `hint`: a face that may be near, which only saves time.
    SurfacePoint nearest_facing(Vec3d p, Vec3d normal, double reach, std::uint32_t hint = SurfacePoint::none) const;

  private:
    struct Node
    {
        Vec3f low;
        Vec3f high;
        std::uint32_t first = 0;  ///< Leaf: index into order_; otherwise the second child, the first one follows.
        std::uint32_t count = 0;  ///< Faces of a leaf; 0: not a leaf.
    };

    std::uint32_t build(std::uint32_t begin, std::uint32_t end, const std::vector<Vec3f>& middles);
    void try_face(std::uint32_t face, Vec3d p, const Vec3d* normal, SurfacePoint& best) const;
    SurfacePoint search(Vec3d p, const Vec3d* normal, double reach, std::uint32_t hint) const;
    std::array<Vec3d, 3> corners(std::uint32_t face) const;

    const Mesh& mesh_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace fresco::geometry

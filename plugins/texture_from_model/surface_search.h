#pragma once

#include <fresco/mesh.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

/// \file Finds the nearest point of the model for each texel of the atlas. Used by transfer_colors().

namespace from_model
{

/// A point of a mesh's surface.
struct SurfacePoint
{
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    std::uint32_t face = none;
    std::array<double, 3> weights{};  ///< Of the face's corners; they add up to 1.
    double squared_distance = std::numeric_limits<double>::infinity();

    bool found() const { return face != none; }
};

/// The point of a triangle that is nearest to `p`. Ericson, "Real-Time Collision Detection" (2005), section 5.1.5.
std::array<double, 3> nearest_weights(const std::array<fresco::Vec3d, 3>& corners, fresco::Vec3d p);

/// Finds nearest surface points by a tree of boxes. Exact; safe to use from several threads.
class SurfaceSearch
{
  public:
    /// The mesh must have passed check_mesh and outlive the search.
    explicit SurfaceSearch(const fresco::Mesh& mesh);

    /// The nearest point at most `reach` away on a face whose normal is less than 90 degrees from `normal`, so that the back
    /// of a thin wall does not count; among equally near points that of the lowest face. `hint`: a face that may be
    /// near, which only saves time.
    SurfacePoint nearest(fresco::Vec3d p, fresco::Vec3d normal, double reach, std::uint32_t hint = SurfacePoint::none) const;

  private:
    struct Node
    {
        fresco::Vec3f low;
        fresco::Vec3f high;
        std::uint32_t first = 0;  ///< Leaf: index into order_; otherwise the second child, the first one follows.
        std::uint32_t count = 0;  ///< Faces of a leaf; 0: not a leaf.
    };

    std::uint32_t build(std::uint32_t begin, std::uint32_t end, const std::vector<fresco::Vec3f>& middles);
    void try_face(std::uint32_t face, fresco::Vec3d p, fresco::Vec3d normal, SurfacePoint& best) const;
    std::array<fresco::Vec3d, 3> corners(std::uint32_t face) const;

    const fresco::Mesh& mesh_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace from_model

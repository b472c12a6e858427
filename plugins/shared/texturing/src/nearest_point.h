#pragma once

#include <fresco/math.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fresco::texturing
{

/// Finds the nearest of fixed points (a k-d tree).
class NearestPoint
{
  public:
    /// At least one point.
    explicit NearestPoint(std::vector<Vec3f> points);

    /// The number of the point nearest to `query`; the lower one of two equally near.
    std::size_t find(Vec3f query) const;

  private:
    struct Best;
    void split(std::size_t begin, std::size_t end, int axis);
    void search(Vec3f query, std::size_t begin, std::size_t end, int axis, Best& best) const;

    std::vector<Vec3f> points_;
    std::vector<std::uint32_t> order_;
};

}  // namespace fresco::texturing

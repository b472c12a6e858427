#pragma once

#include <fresco/math.h>

#include <cstddef>
#include <cstdint>
#include <vector>

/// Finds the nearest of fixed points (a k-d tree).
class NearestPoint
{
  public:
    /// At least one point.
    explicit NearestPoint(std::vector<fresco::Vec3f> points);

    /// The number of the point nearest to `query`; the lower one of two equally near.
    std::size_t find(fresco::Vec3f query) const;

  private:
    struct Best;
    void split(std::size_t begin, std::size_t end, int axis);
    void search(fresco::Vec3f query, std::size_t begin, std::size_t end, int axis, Best& best) const;

    std::vector<fresco::Vec3f> points_;
    std::vector<std::uint32_t> order_;
};

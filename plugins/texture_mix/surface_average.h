#pragma once

#include <fresco/math.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

/// Smooth means of colors over a surface in space. The atlas plays no part, so that charts neither bleed into each other nor show
/// their seams. Samples are gathered on a grid in space, apart for the six directions of the axes that their normals lean to:
/// the two sides of a board keep their own means. A bilateral grid (Chen, Paris and Durand, "Real-Time Edge-Aware Image
/// Processing with the Bilateral Grid", 2007) with the normal in place of the intensity.
class SurfaceAverage
{
  public:
    /// For points from `low` to `high`, in meters. Waves of `wavelength_m` lose half of their amplitude, shorter ones more.
    /// Throws Error if the grid would have more than 100 million cells.
    SurfaceAverage(fresco::Vec3f low, fresco::Vec3f high, double wavelength_m);

    /// `normal`: unit length.
    void add(fresco::Vec3f point, fresco::Vec3f normal, fresco::Vec3f color);

    /// The mean around a point; `otherwise` if no sample is near. Continuous in point and normal as long as samples are near.
    /// Thread-safe once all samples are added.
    fresco::Vec3f at(fresco::Vec3f point, fresco::Vec3f normal, fresco::Vec3f otherwise) const;

    /// Meters between the nodes of the grid.
    double spacing_m() const { return spacing_; }

  private:
    /// Red, green, blue and weight, summed.
    using Sum = std::array<float, 4>;
    using Node = std::array<Sum, 6>;

    /// Calls `use(cell, weight)` for the eight nodes around a point. \pre the point is within the bounds.
    template <class Use>
    void around(fresco::Vec3f point, Use use) const;

    fresco::Vec3d low_;
    double spacing_ = 0;
    std::array<std::size_t, 3> cells_{};
    std::vector<std::uint32_t> node_of_;  ///< Per cell: its place in nodes_, or none.
    std::vector<Node> nodes_;             ///< Only those near samples.
};

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

    /// Meters between the nodes of the grid.
    double spacing_m() const { return spacing_; }

    /// Looks up means, sooner where the next point is in the same cell of the grid. One for each thread, once all samples are
    /// added; the average must outlive it.
    class Lookup;

  private:
    /// Red, green, blue and weight, summed.
    typedef float Sum __attribute__((vector_size(16)));
    using Node = std::array<Sum, 6>;

    /// Where a point within the bounds is: its cell's first node, and how far on it is to the second, along each axis.
    struct Place
    {
        std::array<std::uint32_t, 3> cell;
        std::array<float, 3> share;
    };
    Place place(fresco::Vec3f point) const;
    /// Of the eight nodes around a cell, x changing first: their places in node_of_.
    std::array<std::size_t, 8> corners(const std::array<std::uint32_t, 3>& cell) const;
    static std::array<float, 8> weights(const std::array<float, 3>& share);

    fresco::Vec3f low_;
    double spacing_ = 0;
    std::array<std::size_t, 3> cells_{};
    std::vector<std::uint32_t> node_of_;  ///< Per cell: its place in nodes_, or none.
    std::vector<Node> nodes_;             ///< Only those near samples.
};

class SurfaceAverage::Lookup
{
  public:
    explicit Lookup(const SurfaceAverage& average);

    /// The mean around a point; `otherwise` if no sample is near. Continuous in point and normal as long as samples are near.
    /// `normal`: of any length.
    fresco::Vec3f at(fresco::Vec3f point, fresco::Vec3f normal, fresco::Vec3f otherwise);

  private:
    const SurfaceAverage& average_;
    std::array<std::uint32_t, 3> cell_;
    std::array<const Node*, 8> nodes_{};
};

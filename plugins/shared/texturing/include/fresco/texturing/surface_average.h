#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

/// \file Smooth means over a surface, which split what a texture shows into bands: colors and strokes (texture.mix), tones and
/// the thickness of paint (texture.relief).

namespace fresco::texturing
{

/// Smooth means of colors over a surface in space, independent of the atlas, so that charts do not bleed into each other and
/// seams do not show. Samples are summed on a grid in space, separately for the six axis directions of their normals, so that the
/// two sides of a board keep their own means. A bilateral grid (Chen, Paris and Durand, "Real-Time Edge-Aware Image Processing
/// with the Bilateral Grid", 2007) with the normal in place of the intensity.
class SurfaceAverage
{
  public:
    /// For points from `low` to `high`, in meters. Waves of `wavelength_m` lose half of their amplitude, shorter ones more.
    /// Throws Error if the grid would have more than 100 million cells; `option`: names what asked for the wavelength.
    SurfaceAverage(Vec3f low, Vec3f high, double wavelength_m, std::string_view option);

    /// `normal`: unit length.
    void add(Vec3f point, Vec3f normal, Vec3f color);

    /// Meters between the nodes of the grid.
    double spacing_m() const { return spacing_; }

    /// Looks up means; faster if successive points are in the same cell of the grid. One per thread, made after all samples were
    /// added; the average must outlive it.
    class Lookup;

  private:
    /// Red, green, blue and weight, summed.
    typedef float Sum __attribute__((vector_size(16)));
    using Node = std::array<Sum, 6>;

    /// A point within the bounds: its cell, and its position in it from 0 to 1 along each axis.
    struct Place
    {
        std::array<std::uint32_t, 3> cell;
        std::array<float, 3> share;
    };
    Place place(Vec3f point) const;
    /// The positions in node_of_ of the eight nodes around a cell, x changing first.
    std::array<std::size_t, 8> corners(const std::array<std::uint32_t, 3>& cell) const;
    static std::array<float, 8> weights(const std::array<float, 3>& share);

    Vec3f low_;
    double spacing_ = 0;
    std::array<std::size_t, 3> cells_{};
    std::vector<std::uint32_t> node_of_;  ///< Per cell: index into nodes_, or none.
    std::vector<Node> nodes_;             ///< Only the nodes near samples.
};

class SurfaceAverage::Lookup
{
  public:
    explicit Lookup(const SurfaceAverage& average);

    /// The mean around a point; `otherwise` if no sample is near. Continuous in point and normal as long as samples are near.
    /// `normal`: of any length.
    Vec3f at(Vec3f point, Vec3f normal, Vec3f otherwise);

  private:
    const SurfaceAverage& average_;
    std::array<std::uint32_t, 3> cell_;
    std::array<const Node*, 8> nodes_{};
};

/// The smooth mean of values at the texels of a texture. Mesh, faces and values must outlive it.
class TexelMeans
{
  public:
    /// `value`: of a texel that a chart covers; called from several threads.
    TexelMeans(const Mesh& mesh, const TexelFaces& faces, std::function<Vec3f(std::size_t texel)> value);

    /// Calls visit(row, mean) for each row with the mean at its texels over waves longer than the wavelength, S x 3, 0 outside
    /// the faces, which it may change; from several threads. The rest as SurfaceAverage has it. Throws Canceled.
    void each_row(double wavelength_m, std::string_view option, const Progress& progress,
                  const std::function<void(std::size_t row, std::vector<float>& mean)>& visit) const;

  private:
    struct Place
    {
        Vec3f point, normal;
    };

    SurfaceAverage averaged(double wavelength_m, std::string_view option, const Progress& progress) const;
    void mean_of_row(std::size_t row, SurfaceAverage::Lookup& mean, std::vector<float>& result) const;
    void mean_of(std::size_t first, std::size_t end, SurfaceAverage::Lookup& mean, float* result) const;
    Place place(std::size_t texel) const;

    const Mesh& mesh_;
    const TexelFaces& faces_;
    std::function<Vec3f(std::size_t)> value_;
    std::vector<Vec3f> normals_;
};

}  // namespace fresco::texturing

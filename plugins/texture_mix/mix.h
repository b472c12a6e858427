#pragma once

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

/// \file Mixes a photo and a painting of one atlas with separate shares of color and strokes, for the stage. Colors and strokes
/// are separated by a smooth mean over the surface (SurfaceAverage).

/// Smooth means of colors over a surface in space, independent of the atlas, so that charts do not bleed into each other and
/// seams do not show. Samples are summed on a grid in space, separately for the six axis directions of their normals, so that the
/// two sides of a board keep their own means. A bilateral grid (Chen, Paris and Durand, "Real-Time Edge-Aware Image Processing
/// with the Bilateral Grid", 2007) with the normal in place of the intensity.
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
    Place place(fresco::Vec3f point) const;
    /// The positions in node_of_ of the eight nodes around a cell, x changing first.
    std::array<std::size_t, 8> corners(const std::array<std::uint32_t, 3>& cell) const;
    static std::array<float, 8> weights(const std::array<float, 3>& share);

    fresco::Vec3f low_;
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
    fresco::Vec3f at(fresco::Vec3f point, fresco::Vec3f normal, fresco::Vec3f otherwise);

  private:
    const SurfaceAverage& average_;
    std::array<std::uint32_t, 3> cell_;
    std::array<const Node*, 8> nodes_{};
};

/// Shares of the painting, 0 to 1.
struct MixShares
{
    double color = 1;
    double strokes = 1;
};

struct Mix
{
    fresco::RasterF rgb;    ///< In [0,1].
    fresco::Raster8 photo;  ///< The inputs in steps of 1/255, and the photo in the painting's colors, without its strokes.
    fresco::Raster8 colors;
    fresco::Raster8 painted;
    /// Mean difference of the channels over the texels of charts, in steps of 1/255.
    double from_photo = 0;
    double from_painted = 0;
};

/// photo + color (colors - photo) + strokes (painted - colors), clamped to [0,1], with colors = photo + mean(painted - photo) by
/// the mean of SurfaceAverage over waves longer than `split_m`: a Laplacian pyramid of two bands, each with a share of the
/// painting. Equal to `photo` if both shares are 0 and to `painted` if both are 1. Pictures are S x S x 3; outside of `faces`
/// the mean is 0. The mesh must have passed check_mesh and have texcoords. Equal for any number of threads. Throws Error,
/// Canceled.
Mix mix(const fresco::RasterF& photo, const fresco::RasterF& painted, const fresco::Mesh& mesh,
        const fresco::texturing::TexelFaces& faces, double split_m, MixShares shares, const fresco::Progress& progress);

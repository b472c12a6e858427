#pragma once

#include "painted_surface.h"

#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <complex>
#include <vector>

/// \file Directions on the surface that strokes follow, from gravity, curvature or drawn lines. The stage chooses the hints and
/// passes the smoothed field to the synthesis, which turns its patches along it.

namespace fresco::synthesize
{

/// Hints for strokes: a direction without a sign at each face, coded as the square of a complex number in the face's own basis,
/// so that opposite directions are equal. The absolute value, at most 1, is the weight of the hint.
class LineHints
{
  public:
    LineHints(const PaintedSurface& surface, const Upright& upright);

    /// Down the slope. Weight: the square of the sine of its angle, 0 on level ground.
    std::vector<std::complex<double>> gravity() const;
    /// The direction of least curvature, along edges and pipes, from the differences of smoothed normals: counts by the
    /// difference of the principal curvatures, fully from 1 / `radius_m` on.
    std::vector<std::complex<double>> curvature(double radius_m) const;
    /// Along the lines in a texture: across the gradients of its luminance, on seen texels. Weight: 1 from the mean gradient on.
    /// Throws Error for a damaged texture, and for one that is of one color on the mesh; Canceled.
    std::vector<std::complex<double>> drawn(const Texture& lines, const Progress& progress) const;

    /// Smooths hints over about `reach_m` and fills faces without any: the least squares of differences from the hints and
    /// between neighbors, each turned along with the surface across their common edge (Knöppel, Crane, Pinkall, Schröder,
    /// "Globally optimal direction fields", SIGGRAPH 2013). F unit vectors along the surface, without a sign; horizontal on parts
    /// of the surface without hints. Throws Canceled.
    std::vector<Vec3f> smoothed(const std::vector<std::complex<double>>& hints, double reach_m, const Progress& progress) const;

  private:
    /// A vector along a face, squared.
    std::complex<double> coded(std::size_t face, Vec3f along) const;
    /// The vector along an edge of a face, from corner `corner`.
    Vec3f edge(std::size_t face, std::size_t corner) const;

    const PaintedSurface& surface_;
    std::vector<TangentFrame> bases_;
    Vec3f up_;
};

}  // namespace fresco::synthesize

#pragma once

#include "painted_surface.h"

#include <fresco/progress.h>
#include <fresco/texture.h>

#include <complex>
#include <vector>

namespace fresco::synthesize
{

/// What strokes can follow: a direction without a sign at each face, coded as the square of a complex number in a basis of the
/// face's own, so that opposite directions are one. Its absolute value, at most 1, says how much the direction counts.
class LineHints
{
  public:
    LineHints(const PaintedSurface& surface, const Upright& upright);

    /// The slope: counts by the square of its sine, not at all on level ground.
    std::vector<std::complex<double>> gravity() const;
    /// The direction of least curvature, along edges and pipes, from the differences of smoothed normals: counts by the difference
    /// of the principal curvatures, fully from 1 / `radius_m` on.
    std::vector<std::complex<double>> curvature(double radius_m) const;
    /// Lines in a texture: across the gradients of its luminance, where it is seen. What is as steep as the mean counts fully.
    /// Throws Error for a damaged texture, or one that shows the mesh nothing but a single color; Canceled.
    std::vector<std::complex<double>> drawn(const Texture& lines, const Progress& progress) const;

    /// Smooths hints over about `reach_m` and fills what has none: the least squares of differences from the hints and between
    /// neighbors, each turned along with the surface across their common edge (Knöppel, Crane, Pinkall, Schröder, "Globally
    /// optimal direction fields", SIGGRAPH 2013). F unit vectors along the surface, of either sign; of a part of the surface
    /// without hints, horizontal. Throws Canceled.
    std::vector<Vec3f> smoothed(const std::vector<std::complex<double>>& hints, double reach_m, const Progress& progress) const;

  private:
    /// A vector along a face, squared.
    std::complex<double> coded(std::size_t face, Vec3f along) const;
    /// From the start of the edge that face and neighbor share, as numbered in the face, to its end.
    Vec3f edge(std::size_t face, std::size_t corner) const;

    const PaintedSurface& surface_;
    std::vector<TangentFrame> bases_;
    Vec3f up_;
};

}  // namespace fresco::synthesize

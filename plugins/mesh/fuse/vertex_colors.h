#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <array>
#include <span>
#include <vector>

/// \file Colors the fused mesh by the color pictures. The stage streams its frames through VertexColors.

namespace fuse
{

/// A depth picture and the color picture of the same moment.
struct ColorView
{
    fresco::Camera depth_camera;
    fresco::RasterF depth;  ///< Meters along the optical axis, 0 = none.
    fresco::Camera color_camera;
    fresco::Raster8 picture;  ///< RGB, of the color camera's size.
};

/// Averages the colors in which cameras see a mesh's vertices. A vertex counts as seen if the depth picture has its distance
/// there; its color is that of the color picture. The weight is the cosine of the viewing angle over the square of the distance.
class VertexColors
{
  public:
    /// `tolerance_m`: how far from the measured surface a vertex may lie. The mesh must outlive this.
    VertexColors(const fresco::Mesh& mesh, double tolerance_m);

    void add(std::span<const ColorView> views, const fresco::Progress& progress);
    /// One per vertex. An unseen vertex gets the colors of its neighbors, otherwise gray.
    std::vector<fresco::Rgb8> colors() const;

  private:
    using Sum = std::array<float, 4>;  ///< Red, green and blue times weights; weights.

    void add(const ColorView& view, const fresco::RigidTransform& camera_from_world, std::size_t vertex);

    const fresco::Mesh& mesh_;
    std::vector<fresco::Vec3f> normals_;
    double tolerance_m_;
    std::vector<Sum> sums_;
};

}  // namespace fuse

#pragma once

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

/// \file The color at any point of a model's surface, from its pictures, colors or shape. transfer_colors() samples it.

namespace from_model
{

/// The source of a model's colors.
enum class ColorSource
{
    pictures,
    colors,  ///< Colors of vertices or materials.
    shape    ///< The model has only one color: shade its shape.
};

ColorSource color_source(const fresco::Model& model);

/// A picture at (u, v) in linear light: bilinear, texel centers at +0.5, wrapped.
fresco::Vec3d sample_wrapped(const fresco::Raster8& picture, fresco::Vec2d uv, fresco::Wrap wrap_u, fresco::Wrap wrap_v);

/// Half the size, averaged in linear light; the last row or column of an odd side goes to the last texel.
fresco::Raster8 halved(const fresco::Raster8& picture);

/// The color at points of a model's surface, in linear light. Safe to use from several threads.
class ModelColors
{
  public:
    /// `pictures`: those of the model, decoded, of any size. The model must outlive this.
    ModelColors(const fresco::Model& model, std::vector<fresco::Raster8> pictures);
    /// For a model without colors: shades its shape.
    explicit ModelColors(const fresco::Model& model);

    fresco::Vec3d at(std::uint32_t face, const std::array<double, 3>& weights) const;

    /// Pixels of the picture per meter of a face; 0 without a picture.
    double pixels_per_meter(std::uint32_t face) const;

  private:
    const fresco::Model& model_;
    std::vector<fresco::Raster8> pictures_;
    std::vector<float> corner_lights_;  ///< 3F or empty: the shape's.
};

/// Shades a mesh by its shape: 3F linear lights, one per corner. A lamp stands obliquely above the mesh, at the distance of the
/// mesh's size from its middle; lightness depends on the angle to it all the way to the back, so that adjacent sides differ and
/// large sides are not flat. Convex places are a little lighter, concave ones darker. Corner normals average the adjacent faces
/// within 40 degrees, so that edges stay sharp. L* lies between 20 and 90.
std::vector<float> shape_lights(const fresco::Mesh& mesh);

}  // namespace from_model

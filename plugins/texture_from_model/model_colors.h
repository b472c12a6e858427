#pragma once

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/model.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace from_model
{

/// What a model has to show.
enum class ColorSource
{
    pictures,
    colors,  ///< Of vertices or materials.
    shape    ///< One color everywhere: only the shape shows.
};

ColorSource color_source(const fresco::Model& model);

/// A picture at (u, v) in linear light: bilinear, texel centers at +0.5, wrapped.
fresco::Vec3d sample_wrapped(const fresco::Raster8& picture, fresco::Vec2d uv, fresco::Wrap wrap_u, fresco::Wrap wrap_v);

/// Half the size, averaged in linear light; of an odd side the last row or column counts for the last texel.
fresco::Raster8 halved(const fresco::Raster8& picture);

/// The color at points of a model's surface, in linear light. Safe to use from several threads.
class ModelColors
{
  public:
    /// `pictures`: those of the model, decoded, perhaps made smaller. The model must outlive this.
    ModelColors(const fresco::Model& model, std::vector<fresco::Raster8> pictures);
    /// Of a model without colors: shaded by its shape.
    explicit ModelColors(const fresco::Model& model);

    fresco::Vec3d at(std::uint32_t face, const std::array<double, 3>& weights) const;

    /// Pixels of its picture that a face has per meter; 0 without a picture.
    double pixels_per_meter(std::uint32_t face) const;

  private:
    const fresco::Model& model_;
    std::vector<fresco::Raster8> pictures_;
    std::vector<float> corner_lights_;  ///< 3F or empty: the shape's.
};

/// Twice the area of a face in square meters, and in the square of its texcoords.
double twice_area(const fresco::Mesh& mesh, std::uint32_t face);
double twice_uv_area(const fresco::Mesh& mesh, std::uint32_t face);

}  // namespace from_model

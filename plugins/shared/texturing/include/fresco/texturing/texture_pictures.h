#pragma once

#include <fresco/image.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// \file Pictures of textures: from layers to one picture, linear light, gutters, smaller ones.

namespace fresco::texturing
{

/// Throws Error unless the texture is what its contract says: 1 or more square layers of 3 channels, layer i of size S / 2^i,
/// `seen` of S x S, known values.
void check_texture(const Texture& texture);

/// The texture's picture at full size, S x S x 3: displayed RGB in [0,1], the sum over the layers of a bilinear lookup at each
/// texel center. Rows are shared among progress.threads() threads. Throws Error if a texel is not finite, Canceled.
RasterF collapse(const Texture& texture, const Progress& progress);

/// Displayed RGB in steps of 1/255; what lies outside [0,1] is clamped.
Raster8 to_bytes(const RasterF& rgb, const Progress& progress);

/// Linear light in [0,1] of an 8-bit sRGB step (IEC 61966-2-1).
double to_linear(std::uint8_t step);
/// The sRGB step nearest to a linear light, by the curve's value; beyond [0,1] the first or last.
std::uint8_t from_linear(double light);
/// The sRGB value of a linear light, both in [0,1]; beyond them the nearest.
double displayed(double light);

/// Gives every texel that is no source the color of its nearest source (exact Euclidean distance between centers; of equally
/// near ones the same is taken for any thread count), so that bilinear lookups and mip-maps find no foreign color at a chart's
/// border. `is_source`: W x H. Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions" (2012). Throws Error if
/// there is no source, Canceled.
void fill_from_nearest(Raster8& image, const std::vector<std::uint8_t>& is_source, const Progress& progress);

/// A picture with alpha, split into colors and a mask.
struct OpaquePicture
{
    Raster8 rgb;     ///< A transparent pixel has the color of the nearest one that is not.
    Raster8 opaque;  ///< 255; 0: transparent (see least_opaque_alpha).
};
/// Throws Error naming `source` if all pixels are transparent, Canceled. \pre picture.channels == 4
OpaquePicture opaque_picture(const Raster8& picture, const std::string& source, const Progress& progress);

/// The mesh's picture with at most `max_px` texels a side; as it is where it is no larger or `max_px` is 0. A texel averages, by
/// area and in linear light, only the texels of its own chart, and the gutter is filled again from the nearest chart texels: no
/// color crosses from chart to chart until one texel holds parts of both, where the chart at its center wins. Equal for any
/// number of threads. The mesh must have passed check_mesh and have texcoords, the picture must be square. Throws Canceled.
Raster8 smaller_picture(const TexturedMesh& textured, int max_px, const Progress& progress);
/// Meaning of a picture's steps, and so of their average.
enum class Steps
{
    light,   ///< sRGB.
    numbers  ///< The steps themselves.
};
/// smaller_picture() for several pictures of a mesh, all of the size that `faces` is for.
std::vector<Raster8> smaller_pictures(const Mesh& mesh, const Charts& charts, const TexelFaces& faces,
                                      std::span<const Raster8> pictures, int max_px, const Progress& progress,
                                      Steps steps = Steps::light);

}  // namespace fresco::texturing

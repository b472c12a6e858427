#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>

namespace fresco::enlarge
{

enum class Colors
{
    painted,    ///< Shifted as in the painting.
    of_picture  ///< As they are in the picture.
};

struct Enlarged
{
    Raster8 picture;           ///< S x S, RGB.
    double painted_share = 0;  ///< Share of the picture; the rest is gutter.
};

/// The picture's pixels along a texel of a texture of `size_px`, if the picture is `picture_width` wide.
double pixels_per_texel(const SourceMap& source, int picture_width, int size_px);

/// Throws Error unless the picture is RGB or RGBA and has the proportions of the one that was painted after.
void check_picture(const SourceMap& source, const Raster8& rgb);

/// Copies the picture through a source map to a texture of `size_px` texels a side, at least the map's. A texel looks up the
/// copies of the 3 x 3 nearest texels of the map that are of its chart; those that continue each other count as one, where they
/// differ the heavier prevails. Shifts are averaged over all of them. `rgb` is the map's picture at any size; transparent pixels
/// have the color of the nearest opaque one. The gutter is filled. The mesh must have passed check_mesh and check_atlas. The same
/// for any number of threads. Throws Error for a map that is empty, Canceled.
Enlarged enlarged(const SourceMap& source, const Raster8& rgb, const Mesh& mesh, int size_px, Colors colors, Progress& progress);

}  // namespace fresco::enlarge

#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/relief.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>

/// \file The relief of paint: how thick it lies by what the picture shows (paint_height), where a painting still shows it
/// (strokes_shown), and how that catches the light (relief_of). The thickness is a function on the surface, so that all are
/// without seams.

/// The thickness of the paint in meters, S x S: between 0 and `height_m`, half of that where the picture is as light as its
/// surroundings, more where it is lighter. What varies over up to two strokes' width counts; twice the usual difference (root
/// mean square over the surface) gives 0.85 of the height. 0 outside of `faces`. `rgb`: S x S x 3. The mesh must have passed
/// check_mesh and have texcoords. Equal for any number of threads. Throws Error where the mesh is too large for such fine means,
/// Canceled.
fresco::RasterF paint_height(const fresco::Raster8& rgb, const fresco::Mesh& mesh, const fresco::texturing::TexelFaces& faces,
                             double height_m, double stroke_m, const fresco::Progress& progress);

/// How much of a picture's strokes a painting shows, S x S, from 0 (none, as where the photo was kept or another picture was
/// painted) to 1. `copied`: the picture copied through `source` in its own colors, S x S x 3, as `painting`. Both are compared by
/// the details of their luma within about eight strokes. Blending does not lower the value; a mixture gets a value between 0
/// and 1. Texels beside charts have the largest share around them. Equal for any number of threads. Throws as paint_height.
fresco::RasterF strokes_shown(const fresco::Raster8& painting, const fresco::Raster8& copied, const fresco::SourceMap& source,
                              const fresco::Mesh& mesh, const fresco::texturing::TexelFaces& faces, double stroke_m,
                              const fresco::Progress& progress);

/// Leaves the relief only where strokes are shown: elsewhere the surface is bare canvas. \pre Both have one size.
void keep_shown(fresco::Relief& relief, const fresco::RasterF& shown);

/// The normals of a surface that is smooth across vertices and raised by `height` (S x S, meters), and the roughness of paint
/// that is up to `height_m` thick. Slopes are central differences along the face of each texel. Beyond the border of a chart they
/// use the height that the surface has there, on the other side of the seam: the two faces at a seam are laid flat for it.
/// Normals reach one texel past the charts, with the surface's own values where it goes on. Equal for any number of threads.
/// Throws Canceled.
fresco::Relief relief_of(fresco::RasterF height, const fresco::Mesh& mesh, const fresco::texturing::Charts& charts,
                         const fresco::texturing::TexelFaces& faces, double height_m, const fresco::Progress& progress);

#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>
#include <fresco/texturing/texel_faces.h>

/// The photo in the painting's colors, without its strokes: photo + mean(painted - photo), by the mean of SurfaceAverage over
/// waves longer than `split_m`. Pictures are S x S x 3, of texels outside `faces` the photo's; values may leave [0,1]. The mesh
/// must have passed check_mesh and have texcoords. Equal for any number of threads. Throws Error, Canceled.
fresco::RasterF recolored(const fresco::RasterF& photo, const fresco::RasterF& painted, const fresco::Mesh& mesh,
                          const fresco::texturing::TexelFaces& faces, double split_m, const fresco::Progress& progress);

/// photo + color (colors - photo) + strokes (painted - colors), clamped to [0,1]: a Laplacian pyramid of two bands, each with a
/// share of the painting. Equal to `photo` where both shares are 0 and to `painted` where both are 1. The pictures have one size.
fresco::RasterF mix(const fresco::RasterF& photo, const fresco::RasterF& colors, const fresco::RasterF& painted, double color,
                    double strokes, const fresco::Progress& progress);

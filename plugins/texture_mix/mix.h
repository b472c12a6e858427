#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>
#include <fresco/texturing/texel_faces.h>

struct MixOptions
{
    double color;    ///< Of what differs over more than split_m: 0 is the photo's, 1 the painting's.
    double strokes;  ///< Of what differs over less.
    double split_m;
};

/// Between two pictures of a surface, S x S x 3 in [0,1]: P + color · mean(D) + strokes · (D - mean(D)) with D = painted - photo
/// and the mean of SurfaceAverage, clamped to [0,1]. That is a Laplacian pyramid of two bands. Equal to `photo` where both shares
/// are 0 and to `painted` where both are 1. Texels outside `faces` are the photo's. The mesh must have passed check_mesh and have
/// texcoords. Equal for any number of threads. Throws Error, Canceled.
fresco::RasterF mix(const fresco::RasterF& photo, const fresco::RasterF& painted, const fresco::Mesh& mesh,
                    const fresco::texturing::TexelFaces& faces, const MixOptions& options, fresco::Progress& progress);

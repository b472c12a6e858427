#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>

/// \file Mixes a photo and a painting of one atlas with separate shares of color and strokes, for the stage. Colors and strokes
/// are separated by a smooth mean over the surface (SurfaceAverage).

/// Shares of the painting, 0 to 1.
struct MixShares
{
    double color = 1;
    double strokes = 1;
};

struct Mix
{
    fresco::RasterF rgb;    ///< In [0,1].
    fresco::Raster8 photo;  ///< The inputs in steps of 1/255, and the photo in the painting's colors, without its strokes.
    fresco::Raster8 colors;
    fresco::Raster8 painted;
    /// Mean difference of the channels over the texels of charts, in steps of 1/255.
    double from_photo = 0;
    double from_painted = 0;
};

/// photo + color (colors - photo) + strokes (painted - colors), clamped to [0,1], with colors = photo + mean(painted - photo) by
/// the mean of SurfaceAverage over waves longer than `split_m`: a Laplacian pyramid of two bands, each with a share of the
/// painting. Equal to `photo` if both shares are 0 and to `painted` if both are 1. Pictures are S x S x 3; outside of `faces`
/// the mean is 0. The mesh must have passed check_mesh and have texcoords. Equal for any number of threads. Throws Error,
/// Canceled.
Mix mix(const fresco::RasterF& photo, const fresco::RasterF& painted, const fresco::Mesh& mesh,
        const fresco::texturing::TexelFaces& faces, double split_m, MixShares shares, const fresco::Progress& progress);

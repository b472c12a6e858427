#pragma once

#include "size_by_distance.h"
#include "swatches.h"

#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <vector>

/// How large the strokes of a painting are.
struct StrokeSize
{
    double stroke_cm = 0;  ///< Of all swatches together; NaN for fewer than four.
    SizeByDistance by_distance;
    std::size_t swatches = 0;
};

/// Compares a painting with its picture, as far as both are seen in squares five strokes wide, `stroke_cm` being the width that
/// was asked for: the spectrum of L* between a tenth of a stroke and a stroke (Gaussian sigmas), averaged over squares and
/// directions, gives an autocorrelation; where that is half its height, in strokes, is divided by the picture's. So the result is
/// stroke_cm times how much larger strokes are on the surface than they should be. Broad or fine structure that is not the
/// picture's shows in it, too. `uvmaps` may be null. Throws Error for a picture that is smaller than five of its strokes or
/// without contrast, Canceled.
StrokeSize stroke_size(const fresco::TexturedMesh& painting, const fresco::Raster8& style, double stroke_cm,
                       const fresco::UvMaps* uvmaps, const fresco::Progress& progress);

/// The distance in samples at which the autocorrelation of swatches is half its height; NaN without contrast.
double half_width(const std::vector<Swatch>& swatches);

/// How far away, on average, the cameras saw each cell of a square grid over the texture, in meters along their axes, row by row
/// from the lower left; 0 where none did. Throws Error for maps that cannot be read, Canceled.
fresco::RasterF capture_distances(const fresco::UvMaps& uvmaps, int cells_px, const fresco::Progress& progress);

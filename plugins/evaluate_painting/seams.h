#pragma once

#include "seam_pairs.h"

#include <fresco/progress.h>
#include <fresco/texture.h>

#include <cstddef>

/// How much larger color differences (CIE76) are across seams than inside charts.
struct SeamFigures
{
    double across = 0;             ///< Mean over the pairs across seams; NaN without any.
    double inside = 0;             ///< Mean over the pairs inside charts; NaN without any.
    std::size_t across_count = 0;  ///< Pairs whose colors are known.
    std::size_t inside_count = 0;

    /// NaN if one kind has no pairs, or without differences inside.
    double ratio() const;
};

/// Of the picture of a textured mesh: RGB.
SeamFigures seam_figures(const SeamPairs& pairs, const fresco::Raster8& picture, const fresco::Progress& progress);

/// Of a texture, over the pairs that it has seen. Throws Error for a damaged texture, Canceled.
SeamFigures seam_figures(const SeamPairs& pairs, const fresco::Texture& texture, const fresco::Progress& progress);

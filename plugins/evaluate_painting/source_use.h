#pragma once

#include <fresco/source_map.h>

#include <cstddef>

/// How a painting made use of its picture.
struct SourceUse
{
    double picture_used = 0;   ///< Share of the picture's cells that a texel came from, 0..1.
    double largest_share = 0;  ///< Share of the texels that came from one and the same hundredth of the picture, 0..1.
    std::size_t texels = 0;    ///< Texels that came from somewhere.
};

/// A cell is as large as a texel (pixels_per_texel a side); there are at most 8192 along each side of the picture. The hundredth
/// is the square window of 1 % of the picture's area, wherever it holds most, moved by 1/32 of its side. Throws Error if no texel
/// came from the picture.
SourceUse source_use(const fresco::SourceMap& source);

#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <cstddef>
#include <vector>

/// \file Figures of a painted texture, which need no view: how visible the seams between charts are, and how much of the style
/// picture was used. The stage reports them.

/// Two points of the surface, as texcoords.
struct TexcoordPair
{
    fresco::Vec2f first;
    fresco::Vec2f second;
};

/// Pairs that lie equally far apart on the surface.
struct SeamPairs
{
    double distance_m = 0;             ///< Of each pair.
    std::vector<TexcoordPair> across;  ///< To either side of a seam, along all seams.
    std::vector<TexcoordPair> inside;  ///< Within a chart, all over the surface.
};

/// Finds pairs that are two texels apart (mean size of a texel in an atlas of `size_px` a side): one per texel along all seams,
/// and 200,000 inside charts, spread by area. Skips pairs at a crease (faces one or four texels to either side differ by 30
/// degrees or more: corners may be rounded) and pairs whose points do not lie on their chart, near the point that they were
/// measured from. The mesh must have passed check_mesh and have texcoords. Throws Error for a mesh or an atlas without area,
/// Canceled.
SeamPairs find_seam_pairs(const fresco::Mesh& mesh, int size_px, const fresco::Progress& progress);

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

/// Figures of a textured mesh. `picture`: RGB.
SeamFigures seam_figures(const SeamPairs& pairs, const fresco::Raster8& picture, const fresco::Progress& progress);

/// Figures of a texture, over the pairs whose texels were seen. Throws Error for a damaged texture, Canceled.
SeamFigures seam_figures(const SeamPairs& pairs, const fresco::Texture& texture, const fresco::Progress& progress);

/// How much of its picture a painting used.
struct SourceUse
{
    double picture_used = 0;   ///< Share of the picture's cells that at least one texel came from, 0..1.
    double largest_share = 0;  ///< Largest share of the texels that came from one hundredth of the picture, 0..1.
    std::size_t texels = 0;    ///< Texels that came from the picture.
};

/// A cell is as large as a texel (pixels_per_texel a side); there are at most 8192 along each side of the picture. The hundredth
/// is a square window of 1 % of the picture's area, moved in steps of 1/32 of its side. Throws Error if no texel
/// came from the picture.
SourceUse source_use(const fresco::SourceMap& source);

#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <vector>

/// Two points of the surface, as places in the atlas.
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

/// Pairs two texels apart (of the mean size of a texel, `size_px` a side): one per texel along all seams, and 200 000 inside
/// charts, spread by area. Left out are pairs at a crease (faces one or four texels to either side differ by 30 degrees or more:
/// corners may be rounded), and those that do not lie on their chart, near the point they were measured from. The mesh must have
/// passed check_mesh and have texcoords. Throws Error for a mesh or an atlas without area, Canceled.
SeamPairs find_seam_pairs(const fresco::Mesh& mesh, int size_px, const fresco::Progress& progress);

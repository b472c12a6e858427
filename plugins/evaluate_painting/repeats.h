#pragma once

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <span>
#include <vector>

/// \file Measures how often a painting shows one place of its picture again nearby. A coherent copy moves through the picture as
/// far as over the surface, so two points that are farther apart on the surface than in the picture belong to different copies.
/// The stage reports repeats(); the other functions are declared for tests.

/// A point of the surface that was copied from the picture.
struct CopiedPoint
{
    fresco::Vec3f at;       ///< On the surface, in widths of the broad strokes.
    fresco::Vec2f place;    ///< In the picture, in widths of its strokes.
    float scale = 1;        ///< How much narrower strokes are here than the broad ones.
    bool is_motif = false;  ///< The picture has more contrast there, within about a stroke, than at its median place.
};

/// Shares of the surface, 0..1.
struct Repeats
{
    double repeats = 0;  ///< Shows a motif that is seen again within 10 strokes.
    double weave = 0;    ///< Shows one place three times in a row, at steps of 2.5 strokes at most.
};

/// Points of a painting on a regular grid of a quarter of a stroke in each chart (a texel if that is more). `picture`: RGB.
/// Throws Error unless the map has places in a picture of that size, on a mesh with area; Canceled.
std::vector<CopiedPoint> copied_points(const fresco::SourceMap& source, const fresco::Mesh& mesh, const fresco::Raster8& picture,
                                       const fresco::Progress& progress);

/// A point repeats a motif if another one of its scale, 1.5 to 10 strokes away, is from within half a stroke of the same place.
/// It is woven if two others on opposite sides, 0.25 to 2.5 strokes away, are from the same place, within a fifth of a
/// stroke and a quarter of their distance. In strokes of the point's scale. The same for any order of the points and any number
/// of threads. Throws Canceled.
Repeats repeats(std::span<const CopiedPoint> points, const fresco::Progress& progress);

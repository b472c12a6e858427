#pragma once

#include "piece.h"

#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

/// A surface on its way: what is left of a mesh between two cuts into pieces.
struct Surface
{
    std::vector<fresco::Vec3f> positions;
    std::vector<VertexLoad> loads;
    std::vector<fresco::Triangle> triangles;
};

/// Faces by place: the ranges of `order` are compact regions of at most `most` faces, split at fractions of the number of faces
/// that depend on `turn`, so that two turns cut along different lines.
struct Regions
{
    std::vector<std::uint32_t> order;
    std::vector<std::uint32_t> begins;  ///< One more than there are regions.
};
Regions regions_of(const Surface& surface, std::size_t most, int turn, const fresco::Progress& progress);

/// A piece with the way back.
struct CutPiece
{
    std::unique_ptr<Piece> piece;
    std::vector<std::uint32_t> vertices;  ///< By local vertex: the surface's.
};
std::vector<CutPiece> cut(const Surface& surface, const Regions& regions, const fresco::Progress& progress);

/// Writes what is left of the pieces back: places and loads of their vertices, and their faces, in the order of the pieces.
void put_back(const std::vector<CutPiece>& pieces, Surface& surface, const fresco::Progress& progress);

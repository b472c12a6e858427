#pragma once

#include "tile_bins.h"

#include <fresco/uv_mapping/uv_mapper.h>

#include <vector>

/// Finds what pixels see by drawing the mesh's faces into a buffer of depths, a tile at a time. Vertices are projected once for
/// all sizes, in double precision, and snapped to 1/65536 of a pixel (coarser beyond 4096 px), so that no pixel slips between
/// faces that share an edge and one on it belongs to one of them. Memory: 24 bytes per vertex and some 44 per face in sight and
/// size.
class RasterFinder final : public fresco::FaceFinder
{
  public:
    /// The mesh must have passed check_mesh and must outlive the finder.
    explicit RasterFinder(const fresco::Mesh& mesh) : mesh_(mesh) {}

    void find(std::span<const fresco::Camera> cameras, const fresco::Progress& progress,
              std::span<fresco::FaceMap> faces) override;

  private:
    const fresco::Mesh& mesh_;
    std::vector<raster::Projected> projected_;
    std::vector<raster::TileBins> bins_;
};

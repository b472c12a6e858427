#include "raster_finder.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <cstddef>

using raster::Grid;
using raster::Tile;
using raster::TileBins;

namespace
{

constexpr std::size_t faces_per_block = 16384;
/// Every block has a count per tile, which shall not outgrow the faces.
constexpr std::size_t most_blocks = 256;
constexpr std::size_t tiles_at_once = 4;

/// Draws the tile of that number and copies it into the picture.
void draw_tile(const Grid& grid, std::uint32_t number, const std::vector<TileBins>& bins, Tile& tile, fresco::FaceMap& faces)
{
    const auto place = static_cast<int>(number - grid.first_tile);
    const int x = place % grid.tiles_across * Tile::width;
    const int y = place / grid.tiles_across * Tile::height;
    tile.clear(x, y);
    for (const TileBins& some : bins)
        tile.draw(some.pieces(), some.pieces_of(number), grid.bits);
    const int columns = std::min(Tile::width, grid.width - x);
    for (int row = 0; row < std::min(Tile::height, grid.height - y); ++row)
        tile.row(row, columns, &faces.at(x, y + row));
}

}  // namespace

void RasterFinder::find(std::span<const fresco::Camera> cameras, const fresco::Progress& progress,
                        std::span<fresco::FaceMap> faces)
{
    if (cameras.empty())
        return;
    const fresco::Camera& camera = cameras.front();
    const raster::Frustum frustum(camera.intrinsics);
    const fresco::IntoCamera into_camera(camera.world_from_camera);
    raster::project_all(mesh_.positions, into_camera, frustum, progress, projected_);

    std::vector<Grid> grids;
    std::vector<std::size_t> picture_of;
    for (const fresco::Camera& sized : cameras)
    {
        grids.emplace_back(sized.intrinsics, grids.empty() ? 0 : grids.back().end_tile);
        picture_of.resize(grids.back().end_tile, grids.size() - 1);
    }
    const std::size_t count = mesh_.triangles.size();
    const std::size_t block = std::max(faces_per_block, (count + most_blocks - 1) / most_blocks);
    bins_.resize((count + block - 1) / block);
    fresco::parallel_for(count, block, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress.check_canceled();
                             bins_[begin / block].fill(mesh_, begin, end, projected_, frustum, into_camera, grids);
                         });
    fresco::parallel_for(picture_of.size(), tiles_at_once, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress.check_canceled();
                             Tile tile;
                             for (std::size_t number = begin; number < end; ++number)
                             {
                                 const std::size_t picture = picture_of[number];
                                 draw_tile(grids[picture], static_cast<std::uint32_t>(number), bins_, tile, faces[picture]);
                             }
                         });
}

#include <fresco/raycast/ray_finder.h>

#include <fresco/parallel.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace fresco::raycast
{
namespace
{

/// As many rows as Embree's packets of rays are high, some times over.
constexpr int rows_per_block = 16;

struct Rows
{
    std::size_t map;
    int first;
    int end;
};

}  // namespace

void RayFinder::find(std::span<const Camera> cameras, const Progress& progress, std::span<FaceMap> faces)
{
    std::vector<Rows> blocks;
    for (std::size_t i = 0; i < cameras.size(); ++i)
        for (int row = 0; row < faces[i].height; row += rows_per_block)
            blocks.push_back({i, row, std::min(row + rows_per_block, faces[i].height)});
    parallel_items(
        blocks.size(), 1, progress,
        [&](std::size_t block)
        {
            const Rows& rows = blocks[block];
            FaceMap& map = faces[rows.map];
            const auto width = static_cast<std::size_t>(map.width);
            scene_.first_faces(
                cameras[rows.map], rows.first, rows.end,
                std::span(map.values).subspan(map.index(0, rows.first), static_cast<std::size_t>(rows.end - rows.first) * width));
        });
}

}  // namespace fresco::raycast

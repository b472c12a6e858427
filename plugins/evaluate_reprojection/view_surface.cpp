#include "view_surface.h"

#include <fresco/parallel.h>
#include <fresco/raycast/surface.h>

#include <algorithm>
#include <vector>

using namespace fresco;
using raycast::Hit;

namespace
{
}

ViewSurface view_surface(const raycast::Scene& scene, const Camera& camera, const Progress& progress)
{
    const int width = camera.intrinsics.width;
    const int height = camera.intrinsics.height;
    ViewSurface view{camera, RasterF(width, height), Raster8(width, height),
                     Raster<std::uint32_t>(width, height, 1, std::uint32_t{Hit::none})};
    parallel_for(static_cast<std::size_t>(height), 8, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<Hit> hits((end - begin) * static_cast<std::size_t>(width));
                     scene.cast_rows(camera, static_cast<int>(begin), static_cast<int>(end), hits);
                     const std::size_t first = begin * static_cast<std::size_t>(width);
                     for (std::size_t i = 0; i < hits.size(); ++i)
                         if (raycast::sight(hits[i]) == raycast::Sight::surface)
                         {
                             view.depth.values[first + i] = static_cast<float>(hits[i].distance);
                             view.triangles.values[first + i] = hits[i].triangle;
                         }
                 });
    find_inner_pixels(view);
    return view;
}

void find_inner_pixels(ViewSurface& view)
{
    const int width = view.depth.width;
    const int height = view.depth.height;
    const auto all_seen = [&](int x, int y)
    {
        for (int ny = std::max(0, y - 1); ny <= std::min(height - 1, y + 1); ++ny)
            for (int nx = std::max(0, x - 1); nx <= std::min(width - 1, x + 1); ++nx)
                if (view.depth.at(nx, ny) <= 0)
                    return false;
        return true;
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            view.inner.at(x, y) = all_seen(x, y) ? 1 : 0;
}

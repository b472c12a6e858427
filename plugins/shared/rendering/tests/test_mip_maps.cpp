#include "catch.h"

#include <fresco/random.h>
#include <fresco/rendering/view_renderer.h>

#include <cmath>
#include <utility>

using namespace fresco;
using namespace fresco::rendering;

TEST_CASE("each level is the area average of the one before, whether its sides are even or not")
{
    Random random(5);
    for (const auto& [width, height] : {std::pair{64, 48}, std::pair{64, 33}, std::pair{31, 48}})
    {
        Raster8 picture(width, height, 3);
        RasterF level(width, height, 3);
        for (std::size_t i = 0; i < picture.values.size(); ++i)
            level.values[i] = picture.values[i] = static_cast<std::uint8_t>(256 * random.uniform());
        const MipMaps maps(picture, TextureFilter::trilinear);
        for (int lod = 0; lod < 4; ++lod)
        {
            double apart = 0;
            for (int y = 0; y < level.height; ++y)
                for (int x = 0; x < level.width; ++x)
                {
                    const Vec3d color = maps.sample({(x + 0.5) / level.width, 1 - (y + 0.5) / level.height}, lod);
                    for (const auto& [c, value] : {std::pair{0, color.x}, std::pair{1, color.y}, std::pair{2, color.z}})
                        apart = std::max(apart, std::abs(value - double{level.at(x, y, c)}));
                }
            CHECK(apart < 0.01);
            level = resized(level, level.width / 2, level.height / 2);
        }
    }
}

#include "catch.h"

#include <fresco/random.h>
#include <fresco/rendering/mip_maps.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <utility>

using namespace fresco;
using namespace fresco::rendering;

TEST_CASE("each level is the area average of the one before, whether its sides are even or not")
{
    for (const auto& [width, height] : {std::pair{64, 48}, std::pair{64, 33}, std::pair{31, 48}})
    {
        const Raster8 picture = testing::noise_picture(width, height, 5);
        RasterF level(width, height, 3);
        std::ranges::copy(picture.values, level.values.begin());
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
            // Ten bits per channel hold a quarter of a step.
            CHECK(apart < (lod == 0 ? 1e-9 : 0.126));
            level = resized(level, level.width / 2, level.height / 2);
        }
    }
}

TEST_CASE("a batch of lookups gives the colors of single ones, beyond the borders and between levels, too")
{
    Random random(6);
    for (const auto& [width, height] : {std::pair{64, 33}, std::pair{1, 1}})
    {
        const MipMaps maps(testing::noise_picture(width, height, 7), TextureFilter::trilinear);
        Lookups lookups(maps);
        for (const std::size_t count : {std::size_t{1}, std::size_t{7}, std::size_t{200}, std::size_t{5}})
        {
            lookups.start(count);
            std::vector<Vec3d> expected;
            std::vector<std::size_t> ends;
            for (std::size_t i = 0; i < count; ++i)
            {
                const Vec2d uv{1.4 * random.uniform() - 0.2, 1.4 * random.uniform() - 0.2};
                const double lod = std::max(0.0, 10 * random.uniform() - 3);
                const auto weight = static_cast<float>(random.uniform());
                expected.push_back(maps.sample(uv, lod) * double{weight});
                lookups.add(uv.x * width, uv.y * height, lod, weight);
                ends.push_back(lookups.count());
            }
            lookups.look_up();
            double apart = 0;
            for (std::size_t i = 0, place = 0; i < count; ++i)
            {
                Vec3d color;
                for (; place < ends[i]; ++place)
                    color += Vec3d{lookups.colors(0)[place], lookups.colors(1)[place], lookups.colors(2)[place]};
                apart = std::max(apart, length(color - expected[i]));
            }
            CHECK(apart < 0.01);
        }
    }
}

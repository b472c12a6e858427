#include "catch.h"

#include <fresco/uv_mapping/view_frames.h>

#include <cmath>
#include <vector>

using namespace fresco;

TEST_CASE("views of uv maps find their frames by sequence and name, in any order")
{
    UvMaps maps;
    maps.views = {{"b", "0", {}, {}}, {"a", "1", {}, {}}, {"a", "0", {}, {}}};
    Frames frames;
    for (const auto& [sequence, name] : {std::pair{"a", "0"}, {"x", "9"}, {"a", "1"}, {"b", "0"}})
    {
        frames.frames.emplace_back().sequence = sequence;
        frames.frames.back().name = name;
    }
    CHECK(frames_of_views(maps, frames) == std::vector<std::size_t>{3, 2, 0});
    frames.frames.erase(frames.frames.begin() + 2);
    CHECK_THROWS_WITH(frames_of_views(maps, frames), Catch::Contains("a/1, which is missing on port 'frames'"));
}

TEST_CASE("the sensor's depth is looked up where the depth camera sees the surface point")
{
    // Both cameras look along z; the depth camera stands 0.1 m to the right, at half the size.
    Camera color{{16, 12, 16, 16, 8, 6}, {}};
    Camera depth{{8, 6, 8, 8, 4, 3}, {}};
    depth.world_from_camera.translation = {0.1, 0, 0};
    const UvMap map{RasterF(16, 12, 2, 0.5F), RasterF(16, 12, 1, 2.0F), RasterF(16, 12, 1, 1.0F), Raster8(16, 12, 1, 1)};
    RasterF measured(8, 6);
    for (std::size_t i = 0; i < measured.values.size(); ++i)
        measured.values[i] = 2 + static_cast<float>(i) * 0.01F;
    measured.at(4, 3) = 0;
    const auto found = sensor_depth(map, color, depth, measured);
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 16; ++x)
        {
            CAPTURE(x, y);
            // X = (x + 0.5 - 8) / 16 * 2; column = 8 (X - 0.1) / 2 + 4 = (x + 0.5) / 2 - 0.4
            const int column = static_cast<int>(std::floor((x + 0.5) / 2 - 0.4));
            const int row = y / 2;
            CHECK(found.at(x, y) == (column < 0 ? 0 : measured.at(column, row)));
        }
}

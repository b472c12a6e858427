#include "catch.h"

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/texturing/texture_pictures.h>

using namespace fresco;
using namespace fresco::texturing;

TEST_CASE("every gutter texel has the color of a nearest source")
{
    const int width = 61;
    const int height = 37;
    for (const int density : {2, 40, 400})
    {
        Raster8 image(width, height, 3);
        std::vector<std::uint8_t> source(static_cast<std::size_t>(width * height), 0);
        Random random(static_cast<std::uint64_t>(density));
        for (auto& is_source : source)
            is_source = random.below(2000) < density ? 1 : 0;
        source[700] = 1;
        // A source's color is its place.
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if (source[static_cast<std::size_t>(y * width + x)])
                {
                    image.at(x, y, 0) = static_cast<std::uint8_t>(x);
                    image.at(x, y, 1) = static_cast<std::uint8_t>(y);
                    image.at(x, y, 2) = 255;
                }
        const Raster8 before = image;
        testing::TestRun run;
        fill_from_nearest(image, source, run);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
            {
                int nearest = width * width + height * height;
                for (int sy = 0; sy < height; ++sy)
                    for (int sx = 0; sx < width; ++sx)
                        if (source[static_cast<std::size_t>(sy * width + sx)])
                            nearest = std::min(nearest, (sx - x) * (sx - x) + (sy - y) * (sy - y));
                const int dx = image.at(x, y, 0) - x;
                const int dy = image.at(x, y, 1) - y;
                REQUIRE(image.at(x, y, 2) == 255);
                REQUIRE(dx * dx + dy * dy == nearest);
            }
        testing::TestRun many(7);
        Raster8 again = before;
        fill_from_nearest(again, source, many);
        CHECK(again == image);
    }
}

TEST_CASE("without any source the atlas is refused")
{
    Raster8 image(4, 4, 3);
    testing::TestRun run;
    CHECK_THROWS_WITH(fill_from_nearest(image, std::vector<std::uint8_t>(16, 0), run), Catch::Contains("cover no texel"));
}

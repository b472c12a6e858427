#include "catch.h"
#include "pixel_links.h"

#include <vector>

using namespace fresco;
using namespace fresco::from_frames;

namespace
{

/// Depths in meters, 0: nothing there. u grows by 1/100 a pixel, v by 1/100 against the rows.
UvMap uv_map_of(const std::vector<std::vector<float>>& rows)
{
    const int width = static_cast<int>(rows.front().size());
    const int height = static_cast<int>(rows.size());
    UvMap map{RasterF(width, height, 2), RasterF(width, height), RasterF(width, height), Raster8(width, height)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const float depth = rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
            map.depth.at(x, y) = depth;
            map.valid.at(x, y) = depth > 0 ? 1 : 0;
            map.uv.at(x, y, 0) = 0.01F * static_cast<float>(x);
            map.uv.at(x, y, 1) = 0.9F - 0.01F * static_cast<float>(y);
            map.cosine.at(x, y) = 1;
        }
    return map;
}

/// So far away in pixels that a row's points lie straight before it: what is between two pixels is depth / focal.
Camera camera_of(const UvMap& map, double focal = 100)
{
    Camera camera;
    camera.intrinsics = {map.valid.width, map.valid.height, focal, focal, map.valid.width / 2.0, map.valid.height / 2.0};
    return camera;
}

UvMap column_of(const std::vector<float>& depths)
{
    std::vector<std::vector<float>> rows;
    for (const float depth : depths)
        rows.push_back({depth});
    return uv_map_of(rows);
}

/// Whether pixel `at` of the depths is linked to the next one; the same in a row and in a column.
bool linked(const std::vector<float>& depths, int at)
{
    const UvMap row = uv_map_of({depths});
    const UvMap column = column_of(depths);
    const bool right = PixelLinks(row, camera_of(row)).has(at, 0, PixelLinks::surface_right);
    const bool down = PixelLinks(column, camera_of(column)).has(0, at, PixelLinks::surface_down);
    CHECK(right == down);
    return right;
}

}  // namespace

TEST_CASE("a depth step is 2 % and 1 cm, from either side")
{
    // At 2 m: 1 - 2 / z > 0.025 from 2.051 m on. At 0.5 m: 1 - 0.5 / z > 0.04 from 0.5208 m on.
    for (const auto& [near, linked_to, not_linked_to] :
         {std::tuple{2.0F, 2.049F, 2.053F}, {0.5F, 0.5200F, 0.5215F}, {8.0F, 8.17F, 8.18F}})
    {
        CAPTURE(near);
        CHECK(linked({near, near, linked_to, linked_to}, 1));
        CHECK(linked({linked_to, linked_to, near, near}, 1));
        CHECK_FALSE(linked({near, near, not_linked_to, not_linked_to}, 1));
        CHECK_FALSE(linked({not_linked_to, not_linked_to, near, near}, 1));
        CHECK(linked({near, linked_to}, 0));
        CHECK_FALSE(linked({near, not_linked_to}, 0));
    }
}

TEST_CASE("an oblique wall has no steps, nor where it begins or ends")
{
    // 1 / z falls by 0.1 a pixel; each link is a step by itself.
    const std::vector<float> wall{1 / 0.5F, 1 / 0.4F, 1 / 0.3F, 1 / 0.2F};
    for (int i = 0; i < 3; ++i)
        CHECK(linked(wall, i));
    CHECK_FALSE(linked({wall[0], wall[1]}, 0));  // Two pixels say no direction.
    // What goes on on one side alone suffices: before the link, and behind it.
    CHECK(linked({wall[0], wall[1], wall[2], 9}, 1));
    CHECK(linked({0.5F, wall[1], wall[2], wall[3]}, 1));
    CHECK(linked({wall[0], wall[1], wall[2]}, 1));
    CHECK(linked({wall[1], wall[2], wall[3]}, 0));
    // Pixels that show nothing say no direction either.
    CHECK_FALSE(linked({0, wall[1], wall[2], 0}, 1));
    CHECK(linked({0, wall[1], wall[2], wall[3]}, 1));
    CHECK(linked({wall[0], wall[1], wall[2], 0}, 1));
    // A wall that goes on two pixels further on, behind a step, is not this one.
    CHECK_FALSE(linked({2, 2, 4, 4}, 1));
}

TEST_CASE("pixels beside steps and beside nothing are marked, those that see nothing are not")
{
    const UvMap map = uv_map_of({{2, 2, 2, 4, 4, 4}, {2, 2, 2, 4, 4, 4}, {2, 2, 2, 4, 4, 0}});
    const auto marked = PixelLinks(map, camera_of(map)).at_steps();
    const std::vector<std::uint8_t> expected{0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 1, 0, 0, 1, 1, 1, 0};
    CHECK(marked.values == expected);

    const UvMap lying = column_of({2, 2, 2, 4, 4, 4});
    const auto in_column = PixelLinks(lying, camera_of(lying)).at_steps();
    CHECK(in_column.values == std::vector<std::uint8_t>{0, 0, 1, 1, 0, 0});
    const UvMap nothing = uv_map_of({{0, 0}, {0, 0}});
    CHECK(PixelLinks(nothing, camera_of(nothing)).at_steps().values == std::vector<std::uint8_t>(4, 0));
}

TEST_CASE("neighbors far apart in the texture are not of one chart, though of one surface")
{
    // 2 m away at 100 px focal length: 2 cm a pixel, and 0.01 of the texture.
    const std::vector<std::vector<float>> wall(9, std::vector<float>(9, 2));
    UvMap map = uv_map_of(wall);
    const PixelLinks whole(map, camera_of(map));
    CHECK(whole.texture_per_m() == Approx(0.5));
    // The camera may be of any size: as wide a view, in more pixels.
    Camera larger = camera_of(map, 400);
    larger.intrinsics = {36, 36, 400, 400, 18, 18};
    CHECK(PixelLinks(map, larger).texture_per_m() == Approx(0.5));

    for (const auto& [gap, together] : {std::pair{0.0499F, true}, {0.0501F, false}})
    {
        CAPTURE(gap);
        UvMap cut = map;
        for (int y = 0; y < 9; ++y)
            for (int x = 5; x < 9; ++x)
                cut.uv.at(x, y, 0) += gap - 0.01F;
        const PixelLinks links(cut, camera_of(cut));
        CHECK(links.has(4, 3, PixelLinks::surface_right));
        CHECK(links.has(4, 3, PixelLinks::texels_right) == together);
        CHECK(links.has(3, 3, PixelLinks::texels_right));
        CHECK(links.has(4, 3, PixelLinks::texels_down));

        UvMap across = map;
        for (int y = 5; y < 9; ++y)
            for (int x = 0; x < 9; ++x)
                across.uv.at(x, y, 1) -= gap - 0.01F;
        const PixelLinks other(across, camera_of(across));
        CHECK(other.has(3, 4, PixelLinks::surface_down));
        CHECK(other.has(3, 4, PixelLinks::texels_down) == together);
        CHECK(other.has(3, 3, PixelLinks::texels_down));
        CHECK(other.has(3, 4, PixelLinks::texels_right));
    }
}

TEST_CASE("the lower quartile of texture per meter is what a view has")
{
    // Three pixels in four lie twice as far away: half the texture per meter. A few have much more, and change nothing.
    std::vector<std::vector<float>> rows(28, std::vector<float>(28, 4));
    for (int y = 0; y < 12; ++y)
        rows[static_cast<std::size_t>(y)].assign(28, 2);
    UvMap map = uv_map_of(rows);
    for (int y = 0; y < 12; y += 3)
        for (int x = 0; x < 28; ++x)
            map.uv.at(x, y, 0) *= 20;
    CHECK(PixelLinks(map, camera_of(map)).texture_per_m() == Approx(0.25));
}

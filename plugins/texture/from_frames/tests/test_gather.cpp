#include "catch.h"
#include "gather.h"
#include "painted_wall.h"

#include <fresco/random.h>
#include <fresco/testing_scenes.h>

#include <map>
#include <vector>

using namespace painted_wall;
using namespace fresco;
using namespace fresco::from_frames;

namespace
{

/// Depths in meters, 0: nothing there. u grows by `step` a pixel, v by `step` against the rows.
UvMap uv_map_of(const std::vector<std::vector<float>>& rows, float step = 0.01F)
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
            map.uv.at(x, y, 0) = step * static_cast<float>(x);
            map.uv.at(x, y, 1) = 0.9F - step * static_cast<float>(y);
            map.cosine.at(x, y) = 1;
        }
    return map;
}

/// Looks straight at a row of points, which are depth / focal apart.
Camera camera_of(const UvMap& map, double focal = 100)
{
    Camera camera;
    camera.intrinsics = {map.valid.width, map.valid.height, focal, focal, map.valid.width / 2.0, map.valid.height / 2.0};
    return camera;
}

std::array<float, 3> rgb_of(const Four& color)
{
    return {color[0], color[1], color[2]};
}

/// The obvious way: every texel asks every triangle of neighboring pixels.
std::map<std::uint32_t, TexelSample> slow_gather(const UvMap& map, const PixelLinks& links, const RasterF& weight,
                                                 const PicturePyramid& picture, int size)
{
    std::map<std::uint32_t, TexelSample> result;
    const auto offer = [&](int column, int row, double sample_weight, double x, double y, double covered)
    {
        if (!(sample_weight > 0))
            return;
        const TexelSample sample{
            static_cast<std::uint32_t>(row * size + column),
            static_cast<float>(sample_weight),
            rgb_of(picture.at({static_cast<float>(x / map.valid.width), static_cast<float>(y / map.valid.height)},
                              static_cast<float>(covered / (map.valid.width * map.valid.height)))),
            {}};
        const auto [place, is_new] = result.emplace(sample.texel, sample);
        if (!is_new && sample.weight > place->second.weight)
            place->second = sample;
    };
    struct At
    {
        int x, y;
    };
    const auto texel_x = [&](At p) { return static_cast<double>(map.uv.at(p.x, p.y, 0)) * size - 0.5; };
    const auto texel_y = [&](At p) { return (1 - static_cast<double>(map.uv.at(p.x, p.y, 1))) * size - 0.5; };
    const auto joined = [&](At a, At b)  // b is right of a or below it.
    {
        return weight.at(a.x, a.y) > 0 && weight.at(b.x, b.y) > 0 &&
               links.has(a.x, a.y, b.x > a.x ? PixelLinks::texels_right : PixelLinks::texels_down);
    };
    std::vector<std::array<At, 3>> triangles;
    Raster<int> whole(map.valid.width, map.valid.height);
    for (int y = 0; y + 1 < map.valid.height; ++y)
        for (int x = 0; x + 1 < map.valid.width; ++x)
        {
            const At a{x, y}, b{x + 1, y}, c{x, y + 1}, d{x + 1, y + 1};
            const bool ab = joined(a, b), cd = joined(c, d), ac = joined(a, c), bd = joined(b, d);
            const bool all = ab && cd && ac && bd;
            for (const At p : {a, b, c, d})
                whole.at(p.x, p.y) += all ? 1 : 0;
            if (all || (ab && ac && !cd && !bd))
                triangles.push_back({a, b, c});
            if (all || (cd && bd && !ab && !ac))
                triangles.push_back({b, d, c});
            if (ab && bd && !cd && !ac)
                triangles.push_back({a, b, d});
            if (cd && ac && !ab && !bd)
                triangles.push_back({a, c, d});
        }
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column)
            for (const auto& [a, b, c] : triangles)
            {
                const double ax = texel_x(b) - texel_x(a), ay = texel_y(b) - texel_y(a);
                const double bx = texel_x(c) - texel_x(a), by = texel_y(c) - texel_y(a);
                const double area = ax * by - ay * bx;
                const double px = column - texel_x(a), py = row - texel_y(a);
                const double s = (px * by - py * bx) / area;
                const double t = (ax * py - ay * px) / area;
                if (area == 0 || s < -1e-9 || t < -1e-9 || s + t > 1 + 1e-9)
                    continue;
                const auto blend = [&](double of_a, double of_b, double of_c)
                { return of_a * (1 - s - t) + of_b * s + of_c * t; };
                offer(column, row,
                      blend(static_cast<double>(weight.at(a.x, a.y)), static_cast<double>(weight.at(b.x, b.y)),
                            static_cast<double>(weight.at(c.x, c.y))),
                      blend(a.x + 0.5, b.x + 0.5, c.x + 0.5), blend(a.y + 0.5, b.y + 0.5, c.y + 0.5), 1 / std::abs(area));
            }
    for (int y = 0; y < map.valid.height; ++y)
        for (int x = 0; x < map.valid.width; ++x)
            if (whole.at(x, y) < 4)
                for (int row = 0; row < size; ++row)
                    for (int column = 0; column < size; ++column)
                        if (const double dx = std::abs(texel_x({x, y}) - column), dy = std::abs(texel_y({x, y}) - row);
                            dx < 1 && dy < 1)
                            offer(column, row, 0.01 * static_cast<double>(weight.at(x, y)) * (1 - dx) * (1 - dy), x + 0.5,
                                  y + 0.5, 1);
    return result;
}

}  // namespace

TEST_CASE("distances agree with a search, to 8 %")
{
    Random random(3);
    Raster8 marked(37, 29);
    for (int i = 0; i < 12; ++i)
        marked.values[static_cast<std::size_t>(random.below(37 * 29))] = 1;
    const RasterF found = distance_to(marked);
    for (int y = 0; y < 29; ++y)
        for (int x = 0; x < 37; ++x)
        {
            double nearest = 1e9;
            for (int v = 0; v < 29; ++v)
                for (int u = 0; u < 37; ++u)
                    if (marked.at(u, v) != 0)
                        nearest = std::min(nearest, std::hypot(u - x, v - y));
            CHECK(static_cast<double>(found.at(x, y)) >= nearest - 1e-4);
            CHECK(static_cast<double>(found.at(x, y)) <= 1.083 * nearest + 1e-4);
        }
    CHECK(distance_to(Raster8(3, 2)).at(1, 1) > 1e5F);
}

TEST_CASE("pixels count by angle and resolution, less at borders and beside steps, not at all where something was in front")
{
    // The depth step is between columns 49 and 50; f = 40 px at 1 m, so 1600 px per m² behind a margin of 10 columns.
    std::vector<float> row(100, 1.0F);
    std::fill(row.begin() + 50, row.end(), 2.0F);
    UvMap map = uv_map_of(std::vector(40, row), 0.005F);
    map.cosine = RasterF(100, 40, 1, 0.8F);
    RasterF measured(100, 40, 1, 1.04F);
    for (int y = 0; y < 40; ++y)
        for (int x = 50; x < 100; ++x)
            measured.at(x, y) = 0;
    measured.at(30, 20) = 0.8F;
    Camera camera = camera_of(map, 40);
    const PixelLinks links(map, camera);
    camera.intrinsics.height = 60;  // Three of its pixels are two of the map.
    // The lower quartile of 0.2 and 0.1 per meter is 0.1 (the left links of both halves are 1 / 40 m and 2 / 40 m long).
    REQUIRE(links.texture_per_m() == Approx(0.1).epsilon(1e-3));
    const RejectedPixels rejected = rejected_pixels(map, measured);
    const auto found = view_weights(map, links, camera, rejected, 1000);
    // 1600 * 0.8 / 1² px per m², 10 000 texels per m², so 0.128 px per texel of the 0.25 that are enough.
    CHECK(found.weight.at(20, 20) == Approx(0.8 * 0.128 / 0.25).epsilon(1e-3));
    CHECK(found.weight.at(70, 20) == Approx(0.8 * 0.032 / 0.25).epsilon(1e-3));
    CHECK(found.trust.at(20, 20) == 1);
    CHECK(view_weights(map, links, camera, rejected, 100).weight.at(20, 20) == Approx(0.8));
    // Beside the step: nothing up to two pixels, then a rise over four.
    for (const auto& [column, trust] : {std::pair{49, 0.0}, {47, 0.0}, {46, 0.25}, {45, 0.5}, {43, 1.0}, {52, 0.0}, {54, 0.5}})
    {
        CAPTURE(column);
        CHECK(found.trust.at(column, 20) == Approx(trust));
        CHECK(found.weight.at(column, 20) ==
              Approx(static_cast<double>(found.weight.at(column < 50 ? 20 : 70, 20)) * std::max(trust, 1e-3)));
    }
    // Pixels 47 to 49 and 50 to 52 of 40 rows, two of which are shared with the rejected pixel's surroundings: none.
    CHECK(found.edge_pixels == 6 * 40 + 12);
    // Over a tenth of the height, four pixels.
    CHECK(found.trust.at(0, 20) == Approx(0.125));
    CHECK(found.trust.at(20, 39) == Approx(0.125));
    CHECK(found.trust.at(20, 37) == Approx(0.625));
    // 20 cm are more than 10 cm + 5 %; where nothing was measured nothing is known.
    CHECK(std::ranges::count(rejected, true) == 1);
    CHECK(found.weight.at(30, 20) == 0);
    CHECK(found.trust.at(31, 20) == 0);
    CHECK(found.weight.at(31, 20) > 0);
}

TEST_CASE("pictures are averaged over what a texel covers")
{
    const Raster8 picture = testing::picture(8, 4, [](int x, int, int) { return x % 2 == 0 ? 0 : 200; });
    const PicturePyramid pyramid(picture);
    const auto color = [&](double x, double footprint) {
        return pyramid.at({static_cast<float>(x / 8), 1.5F / 4}, static_cast<float>(footprint * footprint / 32));
    };
    CHECK(color(2.5, 1)[0] == Approx(0).margin(1e-6));
    CHECK(color(3.5, 0.2)[1] == Approx(200 / 255.0));
    CHECK(color(3.0, 1)[2] == Approx(100 / 255.0));
    CHECK(color(2.5, 2)[0] == Approx(100 / 255.0));
    CHECK(color(2.5, std::sqrt(2.0))[0] == Approx(50 / 255.0));
    CHECK(color(2.5, 1e6)[0] == Approx(100 / 255.0));
}

TEST_CASE("gathering agrees with asking every triangle for every texel")
{
    // Oblique, with a seam, a hole, a strip of single pixels and rejected pixels; finer and coarser than the map.
    const Camera camera = camera_at(0.8, 1, 1.4, 0.5);
    UvMap map = map_of(camera, 24);
    for (int y = 0; y < 24; ++y)
        for (int x = 18; x < 32; ++x)
            map.uv.at(x, y, 1) *= 0.4F;
    for (int x = 3; x < 32; ++x)
        map.valid.at(x, 9) = x % 3 == 0 ? 0 : map.valid.at(x, 9);
    const PixelLinks links(map, camera);
    Random random(11);
    RasterF weight(32, 24);
    for (std::size_t i = 0; i < weight.values.size(); ++i)
        weight.values[i] = map.valid.values[i] == 0 || random.below(20) == 0 ? 0 : static_cast<float>(0.1 + random.uniform());
    const PicturePyramid picture(testing::noise_picture(64, 48, 5));
    for (const int size : {11, 40, 97})
    {
        CAPTURE(size);
        std::map<std::uint32_t, TexelSample> fast;
        gather(
            map, links, weight, {size, 8, false},
            [&](std::size_t block, std::span<const DrawnSample> samples)
            {
                for (const DrawnSample& s : samples)
                {
                    CHECK(s.texel / static_cast<std::uint32_t>(8 * size) == block);
                    REQUIRE(
                        fast.emplace(s.texel, TexelSample{s.texel, s.weight, rgb_of(picture.at(s.at, s.covered)), s.at}).second);
                }
            });
        const auto slow = slow_gather(map, links, weight, picture, size);
        REQUIRE(fast.size() == slow.size());
        for (const auto& [texel, sample] : slow)
        {
            CAPTURE(texel % static_cast<std::uint32_t>(size), texel / static_cast<std::uint32_t>(size));
            REQUIRE(fast.count(texel) == 1);
            CHECK(fast.at(texel).weight == Approx(sample.weight).epsilon(1e-3));
            for (std::size_t c = 0; c < 3; ++c)
                CHECK(fast.at(texel).rgb[c] == Approx(sample.rgb[c]).margin(1e-3));
        }
    }
}

namespace
{

/// Whether pixel `at` of the depths is linked to the next one; the same in a row and in a column.
bool linked(const std::vector<float>& depths, int at)
{
    const UvMap row = uv_map_of({depths});
    std::vector<std::vector<float>> rows;
    for (const float depth : depths)
        rows.push_back({depth});
    const UvMap column = uv_map_of(rows);
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
    // A surface that continues on only one side suffices: before the link, and after it.
    CHECK(linked({wall[0], wall[1], wall[2], 9}, 1));
    CHECK(linked({0.5F, wall[1], wall[2], wall[3]}, 1));
    // Pixels that show nothing say no direction either.
    CHECK_FALSE(linked({0, wall[1], wall[2], 0}, 1));
    CHECK(linked({0, wall[1], wall[2], wall[3]}, 1));
    CHECK(linked({wall[0], wall[1], wall[2], 0}, 1));
    // A wall that goes on two pixels further on, behind a step, is not this one.
    CHECK_FALSE(linked({2, 2, 4, 4}, 1));
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
    }
}

#include "catch.h"
#include "pictures.h"
#include "texture_figures.h"
#include <fresco/testing_scenes.h>

#include <fresco/numerics/noise.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

using namespace fresco;

namespace
{
using Paint = std::function<float(Vec3f)>;

/// Value noise in 0..1 with cells of 3 cm.
float noise_at(Vec3f p)
{
    const auto value = [&](float x, float y)
    { return noise::unit(noise::hash(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y))); };
    const float x = p.x / 0.03F + 10;
    const float y = (p.y + p.z) / 0.03F + 10;
    const float sx = x - std::floor(x);
    const float sy = y - std::floor(y);
    return (value(x, y) * (1 - sx) + value(x + 1, y) * sx) * (1 - sy) +
           (value(x, y + 1) * (1 - sx) + value(x + 1, y + 1) * sx) * sy;
}

/// A gray texture from a function of the surface, seen wherever a face touches a texel.
Texture painted(const Mesh& mesh, int size, const Paint& paint)
{
    Texture texture = testing::blank_texture(size, 0);
    pictures::each_texel(mesh, size,
                         [&](int x, int y, Vec3f at)
                         {
                             for (int c = 0; c < 3; ++c)
                                 texture.layers.front().at(x, y, c) = paint(at);
                             texture.seen.at(x, y) = 1;
                         });
    return texture;
}

Raster8 picture_of(const Texture& texture)
{
    Raster8 picture(texture.size_px(), texture.size_px(), 3);
    for (std::size_t i = 0; i < picture.values.size(); ++i)
        picture.values[i] = static_cast<std::uint8_t>(std::lround(255 * texture.layers.front().values[i]));
    return picture;
}

/// The wall's point at a texcoord: two_chart_wall's charts, inverted.
Vec3d on_wall(Vec2f uv)
{
    if (uv.x < 0.5F)
        return {(double{uv.x} - 0.1) / 0.3, (double{uv.y} - 0.1) / 0.3, 0};
    return {1 + (0.9 - double{uv.x}) / 0.3, (0.4 - double{uv.y}) / 0.3, 0};
}

/// The right half turned about the wall's middle line.
Mesh folded_wall(float angle)
{
    Mesh mesh = testing::two_chart_wall();
    for (Vec3f& p : mesh.positions)
        if (p.x > 1)
        {
            p.z = (p.x - 1) * std::sin(angle);
            p.x = 1 + (p.x - 1) * std::cos(angle);
        }
    return mesh;
}
}  // namespace

TEST_CASE("pairs are two texels apart on the surface, to either side of the seam or within a chart")
{
    const Progress progress;
    const int size = 512;
    const SeamPairs pairs = find_seam_pairs(testing::two_chart_wall(), size, progress);
    CHECK(pairs.distance_m == Approx(2 / (0.3 * size)).epsilon(1e-6));
    CHECK(pairs.across.size() == Approx(0.3 * size).margin(2));
    for (const TexcoordPair& pair : pairs.across)
    {
        const Vec3d a = on_wall(pair.first);
        const Vec3d b = on_wall(pair.second);
        REQUIRE((a.x - 1) * (b.x - 1) < 0);
        REQUIRE(a.y == Approx(b.y).margin(1e-5));
        REQUIRE(length(a - b) == Approx(pairs.distance_m).epsilon(1e-3));
    }
    CHECK(pairs.inside.size() > 190'000);
    double along_x = 0;
    for (const TexcoordPair& pair : pairs.inside)
    {
        const Vec3d step = on_wall(pair.second) - on_wall(pair.first);
        REQUIRE((pair.first.x < 0.5F) == (pair.second.x < 0.5F));
        REQUIRE(length(step) == Approx(pairs.distance_m).epsilon(1e-3));
        along_x += step.x * step.x / dot(step, step);
    }
    CHECK(along_x / static_cast<double>(pairs.inside.size()) == Approx(0.5).margin(0.01));
}

TEST_CASE("a texture that is continuous over the surface shows no seams, charts of other colors do")
{
    const Progress progress;
    const Mesh mesh = testing::two_chart_wall();
    const SeamPairs pairs = find_seam_pairs(mesh, 1024, progress);
    const Texture whole = painted(mesh, 1024, noise_at);
    const double continuous = seam_figures(pairs, picture_of(whole), progress).ratio();
    CHECK(continuous == Approx(1).margin(0.2));
    const auto offset = [](Vec3f p) { return 0.6F * noise_at(p) + (p.x > 1 ? 0.3F : 0.0F); };
    CHECK(seam_figures(pairs, picture_of(painted(mesh, 1024, offset)), progress).ratio() > 3 * continuous);
    // Its own start, at full and at half size.
    const SeamFigures start = seam_figures(pairs, whole, progress);
    CHECK(start.ratio() == Approx(continuous).epsilon(0.03));  // Without the rounding to 8 bits.
    CHECK(start.across_count == pairs.across.size());
    const SeamPairs coarse = find_seam_pairs(mesh, 512, progress);
    CHECK(seam_figures(coarse, painted(mesh, 512, noise_at), progress).ratio() ==
          Approx(seam_figures(coarse, picture_of(whole), progress).ratio()).epsilon(0.2));
}

TEST_CASE("creases are no seams")
{
    const Progress progress;
    CHECK(find_seam_pairs(folded_wall(1.5F), 256, progress).across.empty());
    CHECK(find_seam_pairs(folded_wall(0.6F), 256, progress).across.empty());
    CHECK_FALSE(find_seam_pairs(folded_wall(0.4F), 256, progress).across.empty());
    // Nor is the color across a crease within a chart that of a pair inside.
    Mesh one = folded_wall(1.5F);
    one.texcoords = {{0.1F, 0.1F}, {0.4F, 0.1F}, {0.4F, 0.4F}, {0.1F, 0.1F}, {0.4F, 0.4F}, {0.1F, 0.4F},
                     {0.4F, 0.1F}, {0.7F, 0.1F}, {0.7F, 0.4F}, {0.4F, 0.1F}, {0.7F, 0.4F}, {0.4F, 0.4F}};
    const SeamPairs pairs = find_seam_pairs(one, 256, progress);
    CHECK(pairs.across.empty());
    CHECK(pairs.inside.size() > 150'000);
    const auto halves = [](Vec3f p) { return p.z > 0.001F ? 0.9F : 0.1F; };
    CHECK(seam_figures(pairs, picture_of(painted(one, 256, halves)), progress).inside < 1);
}

TEST_CASE("a rounded corner is a crease, a gentle bend is not")
{
    const Progress progress;
    // The right chart begins with a strip that is turned by 25 degrees, then turns by as much again.
    const auto bent = [](float strip_m)
    {
        const float angle = 25 * std::numbers::pi_v<float> / 180;
        const Vec3f near{1 + strip_m * std::cos(angle), 0, strip_m * std::sin(angle)};
        const Vec3f far = near + Vec3f{std::cos(2 * angle), 0, std::sin(2 * angle)};
        const Vec3f up{0, 1, 0};
        Mesh mesh;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, near, far, up, Vec3f{1, 0, 0} + up, near + up, far + up};
        mesh.triangles = {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}};
        const auto at = [](float u, float y) { return Vec2f{0.1F + 0.3F * u, 0.1F + 0.3F * y}; };
        const float seam = 1.5F;
        const float turn = seam + strip_m;
        const float end = turn + 1;
        mesh.texcoords = {at(0, 0),    at(1, 0),    at(1, 1),    at(0, 0),    at(1, 1),    at(0, 1),
                          at(seam, 0), at(turn, 0), at(turn, 1), at(seam, 0), at(turn, 1), at(seam, 1),
                          at(turn, 0), at(end, 0),  at(end, 1),  at(turn, 0), at(end, 1),  at(turn, 1)};
        return mesh;
    };
    // Texels of 6.5 mm.
    CHECK(find_seam_pairs(bent(0.01F), 512, progress).across.empty());
    CHECK(find_seam_pairs(bent(0.06F), 512, progress).across.size() > 140);
}

TEST_CASE("what the start has not seen does not count")
{
    const Progress progress;
    const Mesh mesh = testing::two_chart_wall();
    const SeamPairs pairs = find_seam_pairs(mesh, 256, progress);
    Texture start = painted(mesh, 256, noise_at);
    for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 128; ++x)
            start.seen.at(x, y) = 0;
    const SeamFigures half = seam_figures(pairs, start, progress);
    CHECK(half.across_count == 0);
    CHECK(half.inside_count == Approx(static_cast<double>(pairs.inside.size()) / 2).epsilon(0.02));
    CHECK(std::isnan(half.ratio()));
    CHECK(std::isnan(seam_figures(pairs, Raster8(256, 256, 3, 7), progress).ratio()));
}

TEST_CASE("a mesh without area is refused")
{
    const Progress progress;
    Mesh flat = testing::two_chart_wall();
    for (Vec2f& uv : flat.texcoords)
        uv.y = 0.5F;
    CHECK_THROWS_WITH(find_seam_pairs(flat, 64, progress), Catch::Contains("no area in its atlas"));
    Mesh point = testing::two_chart_wall();
    for (Vec3f& p : point.positions)
        p = {};
    CHECK_THROWS_WITH(find_seam_pairs(point, 64, progress), Catch::Contains("no area in space"));
}

namespace
{
/// A map of `size` x `size` texels into a picture of 64 x 64.
SourceMap map_of(int size, const std::function<std::optional<Vec2f>(int, int)>& place, int width = 64, int height = 64)
{
    SourceMap map;
    map.picture_width = width;
    map.picture_height = height;
    map.clear(size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            if (const auto at = place(x, y))
                map.set_place(x, y, {*at, 0});
    return map;
}

Vec2f center(int x, int y)
{
    return {static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F};
}
}  // namespace

TEST_CASE("a copy of the picture uses all of it, evenly")
{
    const SourceUse use = source_use(map_of(64, center));
    CHECK(use.texels == 4096);
    CHECK(use.picture_used == 1);
    // A window of 6.4 px holds the centers of 7 x 7 pixels at most.
    CHECK(use.largest_share == Approx(49.0 / 4096));
    // As large texels: two pixels a side, a quarter of the cells.
    SourceMap coarse = map_of(32,
                              [](int x, int y) {
                                  return Vec2f{2.0F * static_cast<float>(x) + 1, 2.0F * static_cast<float>(y) + 1};
                              });
    CHECK(source_use(coarse).picture_used == Approx(0.25));
    coarse.pixels_per_texel = 2;
    CHECK(source_use(coarse).picture_used == 1);
}

TEST_CASE("one spot of the picture repeated is a small part used and a large share")
{
    const SourceUse spot = source_use(map_of(20, [](int, int) { return center(40, 9); }));
    CHECK(spot.picture_used == Approx(1.0 / 4096));
    CHECK(spot.largest_share == 1);
    // Two spots share a window of 6.4 px or they do not.
    for (const auto& [apart, share] : {std::pair{5, 1.0}, std::pair{8, 0.75}})
        CHECK(source_use(map_of(20, [apart = apart](int x, int) { return center(x % 4 == 0 ? 40 + apart : 40, 9); }))
                  .largest_share == Approx(share));
    // The left half, and nothing for every other texel.
    const SourceUse half =
        source_use(map_of(128, [](int x, int y) { return x % 2 == 0 ? std::optional(center(x / 4, y / 2)) : std::nullopt; }));
    CHECK(half.texels == 8192);
    CHECK(half.picture_used == Approx(0.5));
}

TEST_CASE("the picture's border and odd shapes")
{
    const auto corners = [](int x, int y) { return Vec2f{x == 0 ? 0.0F : 640.0F, y == 0 ? 0.0F : 10.0F}; };
    SourceMap strip = map_of(2, corners, 640, 10);
    strip.pixels_per_texel = 4;
    const SourceUse use = source_use(strip);
    CHECK(use.picture_used == Approx(4.0 / (160 * 3)));
    // The window of 8 px does not reach from top to bottom.
    CHECK(use.largest_share == Approx(0.25));
    CHECK_THROWS_WITH(source_use(map_of(4, [](int, int) { return std::nullopt; })),
                      Catch::Contains("has no texel from the picture"));
}

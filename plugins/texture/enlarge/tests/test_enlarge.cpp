#include "catch.h"
#include "plugin_under_test.h"

#include <fresco/random.h>
#include <fresco/testing_scenes.h>
#include <fresco/texturing/enlarge.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

using namespace fresco;

/// The slow, obvious twin: each texel from the definition, in double precision, on the wall of two charts.
namespace plain
{

inline std::array<double, 3> color(const Raster8& rgb, double x, double y)
{
    const auto lobe = [](double t)
    {
        const double a = std::numbers::pi * t;
        return t == 0 ? 1.0 : std::abs(t) >= 3 ? 0.0 : 3 * std::sin(a) * std::sin(a / 3) / (a * a);
    };
    // The outermost pixels have one neighbor among those that count.
    const auto sharp = [&](double t, int k)
    { return 1.04 * lobe(t) - 0.02 * ((k > -2 ? lobe(t + 1) : 0) + (k < 3 ? lobe(t - 1) : 0)); };
    x = std::clamp(x, 0.0, rgb.width - 1.0);
    y = std::clamp(y, 0.0, rgb.height - 1.0);
    std::array<double, 3> sum{};
    double total = 0;
    for (int row = static_cast<int>(y) - 2; row <= static_cast<int>(y) + 3; ++row)
        for (int column = static_cast<int>(x) - 2; column <= static_cast<int>(x) + 3; ++column)
        {
            const double weight = sharp(x - column, column - static_cast<int>(x)) * sharp(y - row, row - static_cast<int>(y));
            total += weight;
            for (int c = 0; c < 3; ++c)
                sum[static_cast<std::size_t>(c)] +=
                    weight * rgb.at(std::clamp(column, 0, rgb.width - 1), std::clamp(row, 0, rgb.height - 1), c);
        }
    for (double& v : sum)
        v /= total;
    return sum;
}

struct Group
{
    double first_x, first_y;  ///< Center of the middle texel in its first copy.
    double weight = 0, x = 0, y = 0;
};

/// Color of texel (column, row) of a texture of `size_px`, in a texel of the map that has a place.
inline std::array<double, 3> enlarged(const SourceMap& map, const Raster8& rgb, int size_px, int column, int row)
{
    const double u = (column + 0.5) * map.size_px() / size_px;
    const double v = (row + 0.5) * map.size_px() / size_px;
    const int middle_x = static_cast<int>(std::floor(u));
    const int middle_y = static_cast<int>(std::floor(v));
    const auto spline = [](double t)
    {
        t = std::abs(t);
        return t < 0.5 ? 0.75 - t * t : t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0.0;
    };
    std::vector<Group> groups;
    Vec3d shift;
    double shifted = 0;
    // The middle first, then row by row.
    for (const int i : {4, 0, 1, 2, 3, 5, 6, 7, 8})
    {
        const int x = middle_x + i % 3 - 1;
        const int y = middle_y + i / 3 - 1;
        // The two charts of the wall lie on both sides of the middle.
        if (x < 0 || y < 0 || x >= map.size_px() || y >= map.size_px() ||
            (2 * x < map.size_px()) != (2 * middle_x < map.size_px()))
            continue;
        const auto place = map.place(x, y);
        if (!place)
            continue;
        const double step = double{map.pixels_per_texel};
        const auto at = [&](double to_x, double to_y)
        {
            const double dx = to_x - (x + 0.5);
            const double dy = to_y - (y + 0.5);
            const double cosine = std::cos(double{place->angle});
            const double sine = std::sin(double{place->angle});
            return std::array{place->at.x + step * (cosine * dx - sine * dy), place->at.y + step * (sine * dx + cosine * dy)};
        };
        const auto [first_x, first_y] = at(middle_x + 0.5, middle_y + 0.5);
        Group* own = nullptr;
        for (Group& group : groups)
            if (own == nullptr && std::hypot(group.first_x - first_x, group.first_y - first_y) <= 0.75 * step)
                own = &group;
        // A copy may continue any of those in a group; those of a group agree here.
        if (own == nullptr)
            own = &groups.emplace_back(Group{first_x, first_y});
        const double weight = spline(u - (x + 0.5)) * spline(v - (y + 0.5));
        const auto [own_x, own_y] = at(u, v);
        shifted += weight;
        shift += vec_cast<double>(place->shift) * (255 * weight);
        own->weight += weight;
        own->x += weight * own_x;
        own->y += weight * own_y;
    }
    std::array<double, 3> sum{};
    double total = 0;
    for (const Group& group : groups)
    {
        if (group.weight == 0)
            continue;
        const double weight = std::pow(group.weight, 4);
        const auto own = color(rgb, group.x / group.weight - 0.5, group.y / group.weight - 0.5);
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += weight * own[c];
        total += weight;
    }
    for (std::size_t c = 0; c < 3; ++c)
        sum[c] = std::clamp(sum[c] / total + (&shift.x)[c] / shifted, 0.0, 255.0);
    return sum;
}

}  // namespace plain

namespace
{

/// Detail of several pixels, as in paintings: RGB.
Raster8 detailed_picture(int width, int height)
{
    return resized(testing::noise_picture((width + 3) / 4, (height + 3) / 4, 7), width, height);
}

/// A map for the wall of two charts: place(x, y) for each texel that touches one of them.
SourceMap painted_map(const Mesh& mesh, int size_px, const Raster8& picture, double pixels_per_texel,
                      const std::function<SourceMap::Place(int, int)>& place)
{
    SourceMap map;
    map.atlas = atlas_id(mesh);
    map.picture_width = picture.width;
    map.picture_height = picture.height;
    map.pixels_per_texel = static_cast<float>(pixels_per_texel);
    map.clear(size_px);
    const auto touches = [size_px](int i, double from)
    { return (i + 1.0) / size_px > from && static_cast<double>(i) / size_px < from + 0.3; };
    for (int y = 0; y < size_px; ++y)
        for (int x = 0; x < size_px; ++x)
            if (touches(size_px - 1 - y, 0.1) && (touches(x, 0.1) || touches(x, 0.6)))
                map.set_place(x, y, place(x, y));
    return map;
}

/// Squares of 4 x 4 texels, each copied from another place in the picture at another angle, in colors shifted by up to `shift`.
SourceMap patched_map(const Mesh& mesh, int size_px, const Raster8& picture, double pixels_per_texel, double shift = 0)
{
    constexpr int side = 4;
    return painted_map(mesh, size_px, picture, pixels_per_texel,
                       [&](int x, int y) -> SourceMap::Place
                       {
                           Random random(static_cast<std::uint64_t>((y / side) * size_px + x / side));
                           const double margin = 0.75 * side * pixels_per_texel;
                           const double from_x = margin + random.uniform() * (picture.width - 2 * margin);
                           const double from_y = margin + random.uniform() * (picture.height - 2 * margin);
                           const double angle = 2 * std::numbers::pi * random.uniform();
                           const double dx = (x % side - (side - 1) / 2.0) * pixels_per_texel;
                           const double dy = (y % side - (side - 1) / 2.0) * pixels_per_texel;
                           const auto any = [&] { return static_cast<float>(shift * (2 * random.uniform() - 1)); };
                           return {.at = {static_cast<float>(from_x + std::cos(angle) * dx - std::sin(angle) * dy),
                                          static_cast<float>(from_y + std::sin(angle) * dx + std::cos(angle) * dy)},
                                   .angle = static_cast<float>(angle),
                                   .shift = {any(), any(), any()}};
                       });
}

}  // namespace

TEST_CASE("copies that continue each other give the picture itself, turned, in mirrored charts too")
{
    // Waves long enough for any interpolation.
    const auto wave = [](double x, double y, int c) { return 128 + 100 * std::sin(0.11 * x + c) * std::cos(0.09 * y - c); };
    const Raster8 picture = fresco::testing::picture(200, 160, [&](int x, int y, int c) { return wave(x + 0.5, y + 0.5, c); });
    for (const auto& of_case : {std::pair{false, 1.0F}, {true, 1.0F}, {false, 4.0F}})
    {
        const bool mirrored = of_case.first;
        const float scale = of_case.second;
        CAPTURE(mirrored, scale);
        Mesh mesh = fresco::testing::two_chart_wall();
        if (mirrored)
            for (Vec2f& uv : mesh.texcoords)
                uv.x = 1 - uv.x;
        constexpr double angle = 0.75;
        constexpr double step = 1.5;
        const auto place = [&](double x, double y)
        {
            const double down = mirrored ? -1 : 1;
            return Vec2d{100 + step * (std::cos(angle) * (x - 32) - down * std::sin(angle) * (y - 50)),
                         80 + step * (std::sin(angle) * (x - 32) + down * std::cos(angle) * (y - 50))};
        };
        const SourceMap map = painted_map(mesh, 64, picture, step / double{scale},
                                          [&](int x, int y) -> SourceMap::Place
                                          {
                                              const Vec2d at = place(x + 0.5, y + 0.5);
                                              return {{static_cast<float>(at.x), static_cast<float>(at.y)}, float{angle}, scale};
                                          });
        testing::TestRun run;
        const Raster8 large = enlarge::enlarged(map, picture, mesh, 256, enlarge::Colors::painted, run).picture;
        double worst = 0;
        for (int y = 156; y < 228; ++y)
            for (int x = 28; x < 100; ++x)
                for (int c = 0; c < 3; ++c)
                {
                    const Vec2d at = place((x + 0.5) / 4, (y + 0.5) / 4);
                    worst = std::max(worst, std::abs(large.at(x, y, c) - wave(at.x, at.y, c)));
                }
        CHECK(worst < 2);
    }
}

TEST_CASE("every texel is what the plain method gives, at whole and odd factors")
{
    const Mesh mesh = fresco::testing::two_chart_wall();
    const Raster8 picture = detailed_picture(128, 96);
    const SourceMap map = patched_map(mesh, 40, picture, 1.3, 0.125);
    testing::TestRun plain_run;
    const Raster8 unshifted = enlarge::enlarged(map, picture, mesh, 97, enlarge::Colors::of_picture, plain_run).picture;
    CHECK(unshifted ==
          enlarge::enlarged(patched_map(mesh, 40, picture, 1.3), picture, mesh, 97, enlarge::Colors::painted, plain_run).picture);
    for (const int size_px : {40, 97, 160})
    {
        CAPTURE(size_px);
        testing::TestRun run;
        const enlarge::Enlarged result = enlarge::enlarged(map, picture, mesh, size_px, enlarge::Colors::painted, run);
        // The picture is made smaller first if a texel is wider than a pixel.
        const double along_texel = enlarge::pixels_per_texel(map, picture.width, size_px);
        CHECK(along_texel == Approx(1.3 * 40 / size_px));
        const auto side = [&](int pixels) { return static_cast<int>(std::lround(pixels / std::max(1.0, along_texel))); };
        const Raster8 seen = resized(picture, side(picture.width), side(picture.height));
        SourceMap scaled = map;
        scaled.picture_width = seen.width;
        scaled.picture_height = seen.height;
        scaled.pixels_per_texel *= static_cast<float>(seen.width) / static_cast<float>(picture.width);
        std::size_t painted = 0;
        std::size_t apart = 0;
        for (int y = 0; y < size_px; ++y)
            for (int x = 0; x < size_px; ++x)
            {
                const auto of_map = [&](int i) { return static_cast<int>((i + 0.5) * 40 / size_px); };
                if (!map.place(of_map(x), of_map(y)))
                    continue;
                ++painted;
                const auto plain = plain::enlarged(scaled, seen, size_px, x, y);
                double most = 0;
                for (int c = 0; c < 3; ++c)
                    most = std::max(most, std::abs(result.picture.at(x, y, c) - plain[static_cast<std::size_t>(c)]));
                apart += most > 2.5 ? 1 : 0;
            }
        CHECK(static_cast<double>(painted) > 0.15 * size_px * size_px);
        CHECK(result.painted_share == Approx(static_cast<double>(painted) / (size_px * size_px)));
        CHECK(apart < painted / 200);
    }
}

TEST_CASE_METHOD(testing::StageTest, "no color crosses from chart to chart, and the gutter continues the nearest")
{
    Mesh mesh = fresco::testing::two_chart_wall();
    // The charts touch.
    for (Vec2f& uv : mesh.texcoords)
        uv.x = uv.x < 0.5F ? uv.x + 0.12F : uv.x - 0.08F;
    const Raster8 picture = fresco::testing::picture(64, 64, [](int x, int, int c) { return c == (x < 32 ? 0 : 2) ? 200 : 0; });
    const texturing::Charts charts = texturing::find_charts(mesh);
    const texturing::TexelFaces faces = texturing::find_texel_faces(mesh, charts, 16, run);
    std::vector<int> chart_of(256, -1);
    SourceMap map = painted_map(mesh, 16, picture, 0.5, [](int, int) { return SourceMap::Place(); });
    map.clear(16);
    for (std::size_t texel = 0; texel < 256; ++texel)
        if (faces.covered(texel))
        {
            chart_of[texel] = static_cast<int>(charts.of_face[faces.face[texel]]);
            map.set_place(static_cast<int>(texel % 16), static_cast<int>(texel / 16),
                          {{chart_of[texel] == 0 ? 10.0F : 54.0F, 30}, 0});
        }
    const Raster8 large = enlarge::enlarged(map, picture, mesh, 128, enlarge::Colors::painted, run).picture;
    std::size_t wrong = 0;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x)
        {
            const int chart = chart_of[static_cast<std::size_t>(y / 8 * 16 + x / 8)];
            const bool red = large.at(x, y, 0) == 200 && large.at(x, y, 2) == 0;
            const bool blue = large.at(x, y, 2) == 200 && large.at(x, y, 0) == 0;
            wrong += !(red || blue) || (chart == 0 && blue) || (chart == 1 && red);
        }
    CHECK(wrong == 0);
}

namespace
{

struct Enlarging
{
    Mesh mesh = fresco::testing::two_chart_wall();
    Raster8 picture = detailed_picture(128, 96);
    SourceMap source = patched_map(mesh, 64, picture, 2);
    int size_px = 256;

    std::shared_ptr<TexturedMesh> run(testing::TestRun& run) const
    {
        return testing::output_of<TexturedMesh>("texture.enlarge", "textured_mesh", Value::Map{{"size_px", size_px}},
                                                {{"source", std::make_shared<SourceMap>(source)},
                                                 {"style", std::make_shared<Image>(picture)},
                                                 {"mesh", std::make_shared<Mesh>(mesh)}},
                                                run);
    }
};

}  // namespace

TEST_CASE("size_px 0: as large as the picture allows, and never smaller than what was painted")
{
    const auto made = [](const Raster8& picture, float pixels_per_texel = 2)
    {
        Enlarging enlarging;
        enlarging.picture = picture;
        enlarging.source.pixels_per_texel = pixels_per_texel;
        enlarging.size_px = 0;
        testing::TestRun run;
        const int width = enlarging.run(run)->image.pixels.width;
        CHECK(run.reported.at("size_px").as_double() == width);
        return width;
    };
    // Two pixels a texel at 64 texels a side: half a pixel at 256.
    CHECK(made(detailed_picture(128, 96)) == 256);
    CHECK(made(detailed_picture(200, 150)) == 400);
    CHECK(made(detailed_picture(129, 97)) == 256);
    CHECK(made(detailed_picture(128, 96), 0.4F) == 64);
}

TEST_CASE_METHOD(testing::StageTest, "the stage gives the mesh its picture, of which transparent pixels show nothing")
{
    Enlarging enlarging;
    const auto result = enlarging.run(run);
    CHECK(result->mesh.texcoords == enlarging.mesh.texcoords);
    CHECK(run.reported.at("painted_share").as_double() == Approx(0.18).margin(0.03));
    const Raster8 plain = result->image.pixels;
    const Raster8 rgb = enlarging.picture;
    Raster8 rgba = testing::picture(
        rgb.width, rgb.height, [&](int x, int y, int c) { return c == 3 ? 255 : rgb.at(x, y, c); }, 4);
    enlarging.picture = rgba;
    CHECK(enlarging.run(run)->image.pixels == plain);
    const auto with_left = [&](std::uint8_t color)
    {
        for (int y = 0; y < rgb.height; ++y)
            for (int c = 0; c < 4; ++c)
                rgba.at(0, y, c) = c == 3 ? 0 : color;
        enlarging.picture = rgba;
        return enlarging.run(run)->image.pixels;
    };
    CHECK(with_left(0) == with_left(255));
}

TEST_CASE("the stage says what it cannot use before it begins")
{
    struct Case
    {
        std::function<void(Enlarging&)> change;
        const char* place;
        const char* word;
    };
    for (const Case& c : {Case{[](Enlarging& e) { e.mesh.texcoords.clear(); }, "port 'mesh'", "no texcoords"},
                          {[](Enlarging& e) { e.source.atlas = std::string(32, 'a'); }, "port 'source'", "atlas"},
                          {[](Enlarging& e) { e.picture = Raster8(128, 96, 4); }, "port 'style'", "transparent everywhere"},
                          {[](Enlarging& e) { e.picture = Raster8(128, 96, 1); }, "port 'style'", "1 channels"},
                          {[](Enlarging& e) { e.picture = detailed_picture(128, 128); }, "128x128", "same picture"},
                          {[](Enlarging& e) { e.size_px = 48; }, "size_px 48", "source map's 64"},
                          {[](Enlarging& e) { e.size_px = 512; }, "size_px 512", "256 pixels wide"}})
    {
        CAPTURE(c.place, c.word);
        Enlarging enlarging;
        c.change(enlarging);
        testing::TestRun run;
        CHECK_THROWS_WITH(enlarging.run(run), Catch::Contains(c.place) && Catch::Contains(c.word));
    }
}

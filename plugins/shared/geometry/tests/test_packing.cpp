#include "atlas_check.h"
#include "catch.h"
#include "shapes.h"

#include <fresco/error.h>
#include <fresco/geometry/mesh_stages.h>
#include <fresco/geometry/packing.h>
#include <fresco/random.h>

using namespace fresco::geometry;
using fresco::Vec2d;

namespace
{

/// The slow obvious search.
std::optional<Cell> find_slowly(const std::vector<std::pair<Bitmap, Cell>>& placed, int size, int gap, int margin,
                                const Bitmap& shape)
{
    for (int y = margin; y + shape.height() <= size - margin; ++y)
        for (int x = margin; x + shape.width() <= size - margin; ++x)
        {
            bool fits = true;
            for (const auto& [other, at] : placed)
                for (int j = 0; j < other.height() && fits; ++j)
                    for (int i = 0; i < other.width() && fits; ++i)
                        if (other.get(i, j))
                            for (int v = -gap; v <= gap; ++v)
                                for (int u = -gap; u <= gap; ++u)
                                {
                                    const int sx = at.x + i + u - x;
                                    const int sy = at.y + j + v - y;
                                    if (sx >= 0 && sy >= 0 && sx < shape.width() && sy < shape.height() && shape.get(sx, sy))
                                        fits = false;
                                }
            if (fits)
                return Cell{x, y};
        }
    return std::nullopt;
}

}  // namespace

TEST_CASE("a triangle covers every cell it touches and no other")
{
    fresco::Random random(5);
    for (int round = 0; round < 200; ++round)
    {
        Vec2d t[3];
        for (auto& p : t)
            p = {1 + static_cast<double>(random.below(8000)) / 1000, 1 + static_cast<double>(random.below(8000)) / 1000};
        Bitmap map(12, 12);
        map.cover(t);
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 12; ++x)
                CHECK(map.get(x, y) == atlas_check_detail::touches(t, x, y));
    }
}

TEST_CASE("the bin finds the place that trying every place finds")
{
    fresco::Random random(11);
    const auto below = [&](int count) { return static_cast<int>(random.below(count)); };
    for (const int size : {40, 64, 100})
        for (const int gap : {0, 2})
        {
            ShapeBin bin(size, gap, 1);
            std::vector<std::pair<Bitmap, Cell>> placed;
            for (int n = 0; n < 25; ++n)
            {
                Bitmap shape(1 + below(20), 1 + below(20));
                for (int y = 0; y < shape.height(); ++y)
                    for (int piece = 0; piece < 3; ++piece)
                    {
                        const int x = below(20);
                        shape.set(y, x, x + 1 + below(9));
                    }
                const auto fast = bin.find(shape, 0, size);
                CHECK(fast == find_slowly(placed, size, gap, 1, shape));
                if (fast)
                {
                    bin.put(shape, *fast);
                    placed.emplace_back(shape, *fast);
                }
            }
            CHECK(placed.size() > 5);
        }
}

TEST_CASE("the smallest box of a turned rectangle")
{
    const double angle = 0.4;
    std::vector<Vec2d> points;
    for (const Vec2d p : {Vec2d{0, 0}, {3, 0}, {3, 1}, {0, 1}, {1, 0.5}})
        points.push_back({std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y});
    const double turn = smallest_box_turn(points);
    CHECK(std::abs(std::sin(2 * (turn + angle))) < 1e-9);  // back by the angle, up to quarter turns
    CHECK(smallest_box_turn({{1, 1}}) == 0);
    CHECK(smallest_box_turn({}) == 0);
}

TEST_CASE("equal squares fill the texture, keep their gutter and one scale")
{
    // Sixteen separate unit squares.
    FlatCharts flat;
    fresco::Mesh mesh;
    for (std::uint32_t c = 0; c < 16; ++c)
    {
        flat.corners.insert(flat.corners.end(), {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}});
        flat.chart_of_face.insert(flat.chart_of_face.end(), 2, c);
    }
    mesh.triangles.assign(32, {0, 1, 2});
    flat.axes.resize(16);
    fresco::Progress progress;
    // Cells of one texel, and of two.
    for (const auto& [size_px, gutter_px, cell_px] : {std::tuple{256, 4, 1}, {1100, 3, 2}})
    {
        mesh.texcoords = pack_charts(flat, {.size_px = size_px, .gutter_px = gutter_px}, progress);
        mesh.charts = flat.chart_of_face;
        CHECK(check_atlas(mesh, size_px, gutter_px).none());
        const double texels = double(size_px) * size_px;
        const double square = 2 * std::abs(texcoord_area(mesh, 0)) * texels;
        for (std::size_t f = 0; f < 32; ++f)
            CHECK(std::abs(texcoord_area(mesh, f)) * texels == Approx(0.5 * square).epsilon(1e-4));
        // Four a side: 4 s + 3 * 4 + 2 * 2 <= size, less what touching cells costs.
        const double most = (size_px - 16) / 4.0;
        CHECK(std::sqrt(square) <= most + 1e-3);
        CHECK(std::sqrt(square) > most - 2 * cell_px);
    }
}

TEST_CASE("more charts than texels is an error that says so")
{
    FlatCharts flat;
    flat.axes.resize(3000);
    for (std::uint32_t c = 0; c < flat.axes.size(); ++c)
    {
        flat.corners.insert(flat.corners.end(), {{0, 0}, {1, 0}, {0, 1}});
        flat.chart_of_face.push_back(c);
    }
    fresco::Progress progress;
    CHECK_THROWS_WITH(pack_charts(flat, {.size_px = 64, .gutter_px = 4}, progress), Catch::Contains("size_px"));
}

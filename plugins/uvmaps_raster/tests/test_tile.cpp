#include "catch.h"
#include "tile.h"

#include <fresco/processor.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <vector>

using namespace raster;

namespace
{
constexpr int bits = 4;
constexpr std::uint32_t none = 0xFFFFFFFF;

struct Point
{
    int x;
    int y;
};

std::vector<const TileKernel*> kernels_here()
{
    std::vector<const TileKernel*> kernels{base_kernel()};
    if (avx2_kernel() != nullptr && fresco::runs_avx2())
        kernels.push_back(avx2_kernel());
    if (avx512_kernel() != nullptr && fresco::runs_avx512())
        kernels.push_back(avx512_kernel());
    return kernels;
}

std::size_t index(int x, int y, int stride = Tile::width)
{
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(x);
}

Piece piece_of(std::uint32_t face, Point a, Point b, Point c, std::array<float, 3> nearness = {1, 1, 1})
{
    return {{a.x, b.x, c.x}, {a.y, b.y, c.y}, {nearness[0], nearness[1], nearness[2]}, face};
}

std::vector<std::uint32_t> drawn(const std::vector<Piece>& pieces, int x = 0, int y = 0,
                                 const TileKernel& kernel = fastest_kernel(), int fraction = bits)
{
    Tile tile;
    tile.clear(x, y);
    std::vector<std::uint32_t> numbers(pieces.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    tile.draw(pieces, numbers, fraction, kernel);
    std::vector<std::uint32_t> faces(std::size_t{Tile::width} * Tile::height);
    for (int row = 0; row < Tile::height; ++row)
        tile.row(row, Tile::width, &faces[index(0, row)]);
    return faces;
}

/// How many of the pieces cover each pixel.
std::vector<int> covers(const std::vector<Piece>& pieces)
{
    std::vector<int> count(std::size_t{Tile::width} * Tile::height);
    for (const Piece& piece : pieces)
    {
        const auto faces = drawn({piece});
        for (std::size_t i = 0; i < faces.size(); ++i)
            count[i] += faces[i] == none ? 0 : 1;
    }
    return count;
}
}  // namespace

TEST_CASE("a piece covers the pixel centers inside it, whichever way round it runs")
{
    // Pixels (i, j) with i, j >= 2 and i + j <= 9, its edges just beside the centers.
    const Point a{31, 31};
    const Point b{31, 8 * 16 - 14};
    const Point c{8 * 16 - 14, 31};
    for (const Piece& piece : {piece_of(5, a, b, c), piece_of(5, a, c, b), piece_of(5, c, a, b)})
    {
        const auto faces = drawn({piece});
        for (int y = 0; y < Tile::height; ++y)
            for (int x = 0; x < Tile::width; ++x)
                CHECK(faces[index(x, y)] == (x >= 2 && y >= 2 && x + y <= 9 ? 5 : none));
    }
}

TEST_CASE("every pixel of a triangulated sheet belongs to one piece, also those on edges and corners")
{
    // Corners on pixel centers, halfway and anywhere; corners move too little to fold it.
    std::mt19937 random(3);
    for (const int jitter : {1, 8, 16, 24})
    {
        std::vector<Piece> pieces;
        constexpr int cell = 7 * 16;
        std::vector<Point> corners;
        for (int y = 0; y <= 4; ++y)
            for (int x = 0; x <= 8; ++x)
            {
                const auto shift = [&](int at, int last)
                { return at == 0 || at == last ? 0 : static_cast<int>(random() % 7) % 3 * jitter - jitter; };
                const int dx = shift(x, 8);
                corners.push_back({x * cell + dx, y * cell + shift(y, 4)});
            }
        const auto at = [&](int x, int y) { return corners[static_cast<std::size_t>(y * 9 + x)]; };
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 8; ++x)
                if ((x + y) % 2 == 0)
                {
                    pieces.push_back(piece_of(0, at(x, y), at(x + 1, y), at(x + 1, y + 1)));
                    pieces.push_back(piece_of(0, at(x, y), at(x + 1, y + 1), at(x, y + 1)));
                }
                else
                {
                    pieces.push_back(piece_of(0, at(x + 1, y), at(x, y), at(x, y + 1)));
                    pieces.push_back(piece_of(0, at(x, y + 1), at(x + 1, y), at(x + 1, y + 1)));
                }
        const auto count = covers(pieces);
        for (int y = 1; y < 28; ++y)
            for (int x = 1; x < 56; ++x)
                REQUIRE(count[index(x, y)] == 1);
    }
}

TEST_CASE("a fan about a pixel center covers it once")
{
    const Point middle{10 * 16, 10 * 16};
    std::vector<Piece> fan;
    const std::vector<Point> rim{{80, 160}, {100, 60}, {160, 70}, {240, 100}, {230, 160}, {200, 260}, {160, 250}, {90, 230}};
    for (std::size_t i = 0; i < rim.size(); ++i)
        fan.push_back(piece_of(0, middle, rim[i], rim[(i + 1) % rim.size()]));
    CHECK(covers(fan)[index(10, 10)] == 1);
}

TEST_CASE("a piece without area covers nothing")
{
    CHECK(drawn({piece_of(1, {0, 0}, {160, 160}, {320, 320}), piece_of(2, {32, 32}, {32, 32}, {32, 32}),
                 piece_of(3, {0, 64}, {640, 64}, {64, 64})}) == std::vector<std::uint32_t>(drawn({}).size(), none));
}

TEST_CASE("the nearest piece is seen, of equally near ones the first face, in any order of drawing")
{
    const auto all_over = [](std::uint32_t face, std::array<float, 3> nearness) {
        return piece_of(face, {-16, -16}, {3000, -16}, {-16, 3000}, nearness);
    };
    std::vector<Piece> pieces{all_over(7, {1, 1, 1}), all_over(3, {1, 1, 1}), all_over(4, {0.5F, 0.5F, 0.5F}),
                              all_over(9, {0.9F, 3.0F, 0.9F})};
    const auto faces = drawn(pieces);
    CHECK(faces.front() == 3);
    CHECK(faces[Tile::width - 1] == 9);
    std::mt19937 random(1);
    for (int i = 0; i < 10; ++i)
    {
        std::shuffle(pieces.begin(), pieces.end(), random);
        CHECK(drawn(pieces) == faces);
    }
}

TEST_CASE("a piece is cut at the tile's borders and lies where it lies in any tile")
{
    const Piece piece = piece_of(1, {-5000, -7000}, {30000, 4000}, {2000, 30000});
    const auto here = drawn({piece}, 64, 32);
    const auto beside = drawn({piece}, 60, 30);
    for (int y = 2; y < Tile::height; ++y)
        for (int x = 4; x < Tile::width; ++x)
            CHECK(here[index(x - 4, y - 2)] == beside[index(x, y)]);
}

TEST_CASE("coordinates at the limit do not overflow")
{
    constexpr int far = coordinate_limit / 2;
    const auto faces = drawn({piece_of(6, {-far, -far}, {coordinate_limit, -far}, {-far, coordinate_limit})});
    CHECK(std::count(faces.begin(), faces.end(), 6U) == static_cast<std::ptrdiff_t>(faces.size()));
}

TEST_CASE("every kernel draws what is drawn in whole numbers of 64 bits")
{
    constexpr int fine = 16;
    constexpr int x = 640;
    constexpr int y = 320;
    std::mt19937 random(5);
    for (const int size : {2, 5, 20, 200})
    {
        std::vector<Piece> pieces;
        for (std::uint32_t face = 0; face < 300; ++face)
        {
            const auto within = [&](int middle, int span)
            { return ((middle - span) << fine) + static_cast<int>(random() % (static_cast<unsigned>(2 * span) << fine)); };
            const int column = x + static_cast<int>(random() % Tile::width);
            const int row = y + static_cast<int>(random() % Tile::height);
            const auto point = [&]
            {
                Point p{within(column, size), within(row, size)};
                // Some right on pixel centers.
                return face % 3 == 0 ? Point{p.x >> fine << fine, p.y >> fine << fine} : p;
            };
            const Point a = point();
            const Point b = point();
            const auto nearness = [&] { return 0.1F + static_cast<float>(random() % 1000) / 500; };
            pieces.push_back(piece_of(face, a, b, point(), {nearness(), nearness(), nearness()}));
        }
        // As the finder does: only what reaches into the tile.
        std::erase_if(pieces,
                      [&](const Piece& p)
                      {
                          const auto [left, right] = std::minmax({p.x[0], p.x[1], p.x[2]});
                          const auto [top, bottom] = std::minmax({p.y[0], p.y[1], p.y[2]});
                          return (right >> fine) < x || (left >> fine) >= x + Tile::width - 1 || (bottom >> fine) < y ||
                                 (top >> fine) >= y + Tile::height - 1;
                      });
        REQUIRE(pieces.size() > 100);
        std::array<std::uint64_t, std::size_t{tile_stride} * Tile::height> keys{};
        for (const Piece& piece : pieces)
            draw_wide(piece, fine, x, y, keys.data());
        for (const TileKernel* kernel : kernels_here())
        {
            INFO(kernel->name << ", " << size);
            const auto faces = drawn(pieces, x, y, *kernel, fine);
            int other = 0;
            for (int j = 0; j < Tile::height; ++j)
                for (int i = 0; i < Tile::width; ++i)
                    other += faces[index(i, j)] != ~static_cast<std::uint32_t>(keys[index(i, j, tile_stride)]);
            CHECK(other == 0);
        }
    }
}

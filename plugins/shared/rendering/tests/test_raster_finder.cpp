#include "catch.h"
#include "kernels_here.h"

#include <fresco/parallel.h>
#include <fresco/rendering/raster_finder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

using namespace fresco;
using namespace fresco::rendering;

namespace
{
constexpr int bits = 4;
struct Point
{
    int x;
    int y;
};

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
}  // namespace

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
        for (const TileKernel* kernel : testing::kernels_here(base_kernel(), avx2_kernel(), avx512_kernel()))
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

namespace
{
Intrinsics picture(int width, int height)
{
    return {width, height, 100, 100, width / 2.0, height / 2.0};
}

}  // namespace

TEST_CASE("no cluster is passed over that has a face in sight, also by poses that are not quite rotations")
{
    std::mt19937 random(3);
    const auto along = [&](float reach) { return std::uniform_real_distribution<float>(-reach, reach)(random); };
    Mesh mesh;
    for (std::uint32_t face = 0; face < 3000; ++face)
    {
        const Vec3f middle{along(3), along(3), along(3)};
        for (int corner = 0; corner < 3; ++corner)
            mesh.positions.push_back(middle + Vec3f{along(0.2F), along(0.2F), along(0.2F)});
        mesh.triangles.push_back({3 * face, 3 * face + 1, 3 * face + 2});
    }
    const FaceClusters clusters(mesh);
    const Intrinsics size = picture(300, 200);
    const Frustum frustum(size);
    std::vector<int> seen(mesh.triangles.size());
    std::size_t passed_over = 0;
    for (int view = 0; view < 60; ++view)
    {
        const Vec3d x = normalized(Vec3d{along(1), along(1), along(1)});
        const Vec3d y = normalized(cross(x, Vec3d{along(1), along(1), along(1)}));
        const Vec3d z = cross(x, y);
        RigidTransform pose;
        pose.translation = {along(3), along(3), along(3)};
        for (const auto& [row, axis] : {std::pair{0, x}, {1, y}, {2, z}})
        {
            pose.rotation(row, 0) = 0.996 * axis.x;
            pose.rotation(row, 1) = 0.996 * axis.y;
            pose.rotation(row, 2) = 0.996 * axis.z;
        }
        REQUIRE_NOTHROW(check_camera({size, pose}, "the camera"));
        const IntoCamera into_camera(pose);
        for (std::size_t cluster = 0; cluster < clusters.count(); ++cluster)
        {
            const auto& [center, radius] = clusters.ball(cluster);
            const bool misses = frustum.misses(into_camera.point(center), double{radius});
            passed_over += misses;
            for (const std::uint32_t face : clusters.faces(cluster))
            {
                ++seen[face];
                const auto sides = [&](std::size_t corner)
                { return frustum.project(into_camera.point(mesh.positions[mesh.triangles[face][corner]])).sides; };
                if (misses)
                    REQUIRE(out_of_sight(sides(0), sides(1), sides(2)));
            }
        }
    }
    CHECK(passed_over > 20 * clusters.count());
    CHECK(std::ranges::count(seen, 60) == 3000);

    // One of 3 m, aside but for 3 mm of a corner.
    RigidTransform pose;
    for (int i = 0; i < 3; ++i)
        pose.rotation(i, i) = 0.996;
    const Vec3d inward = normalized(Vec3d{1, 0, -frustum.picture.left});
    const Vec3d corner = Vec3d{2 * frustum.picture.left, 0, 2} + inward * 0.003;
    mesh.positions = {vec_cast<float>(pose.point(corner)), vec_cast<float>(pose.point(corner - inward * 3)),
                      vec_cast<float>(pose.point(corner - inward * 2.9 + Vec3d{0, 0.1, 0}))};
    mesh.triangles = {{0, 1, 2}};
    const FaceClusters one(mesh);
    const auto& [center, radius] = one.ball(0);
    CHECK_FALSE(frustum.misses(IntoCamera(pose).point(center), double{radius}));
}

TEST_CASE("coordinates stay below the limit in pictures of any size")
{
    CHECK(Grid(picture(640, 480), 0).bits == 16);
    CHECK(Grid(picture(4096, 4096), 0).bits == 16);
    CHECK(Grid(picture(4097, 16), 0).bits == 15);
    CHECK(Grid(picture(16, 16384), 0).bits == 14);
    for (const auto& [width, height] : {std::pair{640, 480}, {7282, 4096}, {16384, 4096}, {16, 30000}})
    {
        const Grid grid(picture(width, height), 0);
        const Frustum frustum(picture(width, height));
        for (const double x : {frustum.guard.left, frustum.guard.right})
            for (const double y : {frustum.guard.above, frustum.guard.below})
            {
                const Projected corner{x, y, 1, 0};
                CHECK(std::abs(grid.x(corner)) < coordinate_limit);
                CHECK(std::abs(grid.y(corner)) < coordinate_limit);
            }
        CHECK(grid.x(Projected{-grid.shift_x / grid.scale_x, 0, 1, 0}) == 0);
    }
}

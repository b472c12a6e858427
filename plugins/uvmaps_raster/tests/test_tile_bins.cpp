#include "catch.h"
#include "tile_bins.h"

#include <algorithm>
#include <set>

using namespace fresco;
using namespace raster;

namespace
{
Intrinsics picture(int width, int height)
{
    return {width, height, 100, 100, width / 2.0, height / 2.0};
}

TileBins filled(const Mesh& mesh, const std::vector<Grid>& grids, const Intrinsics& intrinsics)
{
    const Frustum frustum(intrinsics);
    const IntoCamera into_camera(RigidTransform{});
    std::vector<Projected> projected;
    project_all(mesh.positions, into_camera, frustum, Progress{}, projected);
    TileBins bins;
    bins.fill(mesh, 0, mesh.triangles.size(), projected, frustum, into_camera, grids);
    return bins;
}

std::set<std::uint32_t> faces_in(const TileBins& bins, std::uint32_t tile)
{
    std::set<std::uint32_t> faces;
    for (const std::uint32_t number : bins.pieces_of(tile))
        faces.insert(bins.pieces()[number].face);
    return faces;
}
}  // namespace

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

TEST_CASE("faces are listed in the tiles they reach into, of every picture")
{
    // At depth 1 a unit is 100 pixels of the first picture and 50 of the second.
    Mesh mesh;
    mesh.positions = {{-0.6F, -0.6F, 1}, {0.6F, -0.6F, 1}, {-0.6F, 0.6F, 1},     // over most of the picture
                      {0.2F, 0.2F, 1},   {0.3F, 0.2F, 1},  {0.2F, 0.3F, 1},      // in one tile
                      {0.001F, 0, 1},    {0.002F, 0, 1},   {0.001F, 0.001F, 1},  // between pixel centers
                      {5, 5, 1},         {6, 5, 1},        {5, 6, 1},            // out of sight
                      {0.4F, -0.4F, 1},  {0.5F, -0.4F, 1}, {0.4F, -0.2F, -1}};   // reaches behind the camera
    for (std::uint32_t i = 0; i < 15; i += 3)
        mesh.triangles.push_back({i, i + 1, i + 2});
    const Grid large(picture(128, 128), 0);
    const Intrinsics half = picture(128, 128).scaled_to(64, 64);
    const Grid small(half, large.end_tile);
    REQUIRE(large.end_tile == 8);
    REQUIRE(small.end_tile == 10);
    const TileBins bins = filled(mesh, {large, small}, picture(128, 128));
    for (std::uint32_t tile = 0; tile < 8; ++tile)
    {
        INFO(tile);
        const auto faces = faces_in(bins, tile);
        CHECK(faces.count(0) == 1);
        CHECK(faces.count(1) == (tile == 5 ? 1 : 0));
        CHECK(faces.count(2) == 0);
        CHECK(faces.count(3) == 0);
    }
    CHECK(faces_in(bins, 1).count(4) == 1);
    CHECK(faces_in(bins, 8).count(0) == 1);
    CHECK(faces_in(bins, 9).count(1) == 1);
}

TEST_CASE("corners are in one order, whatever a face begins with")
{
    Mesh mesh;
    mesh.positions = {{-0.6F, -0.6F, 1}, {0.6F, -0.6F, 2}, {-0.6F, 0.6F, 3}};
    mesh.triangles = {{0, 1, 2}, {2, 0, 1}, {1, 0, 2}};
    const Intrinsics intrinsics = picture(64, 64);
    const TileBins bins = filled(mesh, {Grid(intrinsics, 0)}, intrinsics);
    REQUIRE(bins.pieces().size() == 3);
    for (const Piece& piece : bins.pieces())
    {
        CHECK(std::equal(piece.x, piece.x + 3, bins.pieces()[0].x));
        CHECK(std::equal(piece.nearness, piece.nearness + 3, bins.pieces()[0].nearness));
    }
}

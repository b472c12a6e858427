#include "catch.h"
#include "vertex_colors.h"

#include <fresco/testing.h>
#include <fresco/texturing/texture_pictures.h>

#include <cmath>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

/// A right triangle over the lower left half of the picture.
TexturedMesh half_picture(int size)
{
    TexturedMesh textured;
    textured.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    textured.mesh.triangles = {{0, 1, 2}};
    textured.mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}};
    textured.image = Image(Raster8(size, size, 3));
    return textured;
}

}  // namespace

TEST_CASE("a vertex sees the texels of its faces by their nearness, in linear light")
{
    TexturedMesh textured = half_picture(64);
    // Light that rises with u: L = u. The mean of u over the triangle with weight lambda is 1/4 at corners with u = 0 and 1/2 at
    // the one with u = 1.
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c)
                textured.image.pixels.at(x, y, c) = from_linear((x + 0.5) / 64);
    testing::TestRun run;
    const auto colors = vertex_colors(textured, run);
    REQUIRE(colors.size() == 3);
    CHECK(to_linear(colors[0][0]) == Approx(0.25).margin(0.01));
    CHECK(to_linear(colors[1][1]) == Approx(0.5).margin(0.01));
    CHECK(to_linear(colors[2][2]) == Approx(0.25).margin(0.01));
}

TEST_CASE("faces count by their area on the surface, not in the atlas")
{
    TexturedMesh textured = half_picture(8);
    Mesh& mesh = textured.mesh;
    // A second face at vertex 0 with three times the area, over one texel of the other half.
    mesh.positions.insert(mesh.positions.end(), {{-3, 0, 0}, {0, -1, 0}});
    mesh.triangles.push_back({0, 3, 4});
    mesh.texcoords.insert(mesh.texcoords.end(), {{0.9F, 0.9F}, {0.95F, 0.9F}, {0.9F, 0.95F}});
    for (int c = 0; c < 3; ++c)
        textured.image.pixels.at(7, 0, c) = 255;
    testing::TestRun run;
    CHECK(to_linear(vertex_colors(textured, run)[0][0]) == Approx(0.75).margin(0.005));
}

TEST_CASE("faces without area give the texel at the corner, vertices without faces are gray")
{
    TexturedMesh textured = half_picture(4);
    textured.mesh.positions.assign(4, {1, 2, 3});
    textured.image.pixels.at(3, 3, 1) = 99;
    testing::TestRun run;
    const auto colors = vertex_colors(textured, run);
    CHECK(colors[0] == Rgb8{0, 0, 0});
    CHECK(colors[1] == Rgb8{0, 99, 0});
    CHECK(colors[3] == Rgb8{128, 128, 128});
    // A texcoord far outside is at the border that it is beyond.
    textured.mesh.texcoords[1].x = 1e30F;
    CHECK(vertex_colors(textured, run)[1] == Rgb8{0, 99, 0});
    run.cancel_after(1);
    CHECK_THROWS_AS(vertex_colors(textured, run), Canceled);
}

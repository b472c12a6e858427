#include "catch.h"

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

/// Adds a rectangle of two faces with these texels (x to the right, y down) of a picture of `size`, as a chart of its own.
void add_chart(Mesh& mesh, int size, int left, int top, int right, int bottom)
{
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto u = [&](int x) { return static_cast<float>(x) / static_cast<float>(size); };
    const auto v = [&](int y) { return 1 - u(y); };
    for (const auto& [x, y] : {std::pair{left, bottom}, {right, bottom}, {right, top}, {left, top}})
        mesh.positions.push_back({u(x), v(y), static_cast<float>(first)});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
    const Vec2f a{u(left), v(bottom)}, b{u(right), v(bottom)}, c{u(right), v(top)}, d{u(left), v(top)};
    for (const Vec2f uv : {a, b, c, a, c, d})
        mesh.texcoords.push_back(uv);
}

void paint(Raster8& picture, int left, int top, int right, int bottom, std::uint8_t gray)
{
    for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x)
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) = gray;
}

/// Two charts of one color each that fill the halves of a picture of 32, but for a gutter of one texel on both sides of the
/// middle, filled as texture.bake does it.
TexturedMesh two_halves()
{
    TexturedMesh textured;
    add_chart(textured.mesh, 32, 0, 0, 15, 32);
    add_chart(textured.mesh, 32, 17, 0, 32, 32);
    textured.image = Image(Raster8(32, 32, 3));
    paint(textured.image.pixels, 0, 0, 16, 32, 20);
    paint(textured.image.pixels, 16, 0, 32, 32, 220);
    return textured;
}

}  // namespace

TEST_CASE("sRGB's curve: known values, and every step comes back")
{
    CHECK(to_linear(0) == 0);
    CHECK(to_linear(255) == Approx(1));
    CHECK(to_linear(188) == Approx(0.5028865).epsilon(1e-6));
    CHECK(to_linear(10) == Approx(10 / 255.0 / 12.92));
    for (int step = 0; step < 256; ++step)
        CHECK(from_linear(to_linear(static_cast<std::uint8_t>(step))) == step);
    CHECK(from_linear(-1) == 0);
    CHECK(from_linear(2) == 255);
    int last = 0;
    for (int i = 0; i <= 100'000; ++i)
    {
        const double light = i / 100'000.0;
        const int step = from_linear(light);
        REQUIRE(step >= last);
        REQUIRE(std::abs(255 * displayed(light) - step) < 0.5 + 1e-3);
        last = step;
    }
}

TEST_CASE("a smaller picture averages light, not steps")
{
    TexturedMesh textured;
    add_chart(textured.mesh, 8, 0, 0, 8, 8);
    textured.image = Image(Raster8(8, 8, 3));
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            if ((x + y) % 2 == 0)
                paint(textured.image.pixels, x, y, x + 1, y + 1, 255);
    testing::TestRun run;
    // Half the light is step 188; half the steps would be 128.
    for (const std::uint8_t value : smaller_picture(textured, 4, run).values)
        CHECK(value == 188);
    // Thirds of texels: the middle one of three averages 8/3 texels a side, half of them white within a texel's share.
    for (const std::uint8_t value : smaller_picture(textured, 3, run).values)
        CHECK(std::abs(value - 188) <= 12);
    CHECK(smaller_picture(textured, 8, run) == textured.image.pixels);
    CHECK(smaller_picture(textured, 0, run) == textured.image.pixels);
}

TEST_CASE("no color crosses the gutter of a smaller picture, whatever the factor")
{
    const TexturedMesh textured = two_halves();
    testing::TestRun run;
    for (const int size : {16, 11, 7, 4, 2})
    {
        const Raster8 small = smaller_picture(textured, size, run);
        CHECK(small.width == size);
        CHECK(std::ranges::all_of(small.values, [](std::uint8_t v) { return v == 20 || v == 220; }));
        CHECK(small.at(0, 0) == 20);
        CHECK(small.at(size - 1, size - 1) == 220);
    }
}

TEST_CASE("sizes and counts as people read them")
{
    CHECK(grouped(7) == "7");
    CHECK(grouped(499999) == "499 999");
    CHECK(grouped(1234567) == "1 234 567");
    CHECK(file_size(999) == "999 bytes");
    CHECK(file_size(1000) == "1.0 kB");
    CHECK(file_size(999'949) == "999.9 kB");
    CHECK(file_size(999'950) == "1.0 MB");
    CHECK(file_size(12'345'678) == "12.3 MB");
    CHECK(valid_line("a.ply", 12, "3 triangles") == "a.ply: 12 bytes, 3 triangles, valid");
    CHECK(valid_line("a.png", 12, "") == "a.png: 12 bytes, valid");
}

TEST_CASE("what cannot be exported is named")
{
    TexturedMesh textured = two_halves();
    CHECK_NOTHROW(check_textured_mesh(textured, "the mesh"));
    textured.image = Image(Raster8(32, 16, 3));
    CHECK_THROWS_WITH(check_textured_mesh(textured, "the mesh"), Catch::Contains("the mesh has a picture of 32 x 16"));
    textured.mesh.texcoords.clear();
    CHECK_THROWS_WITH(check_textured_mesh(textured, "the mesh"), Catch::Contains("no texcoords"));
}

TEST_CASE("a mesh that was read again is compared to the last bit, but for faces that readers drop")
{
    Mesh meant = two_halves().mesh;
    CHECK_NOTHROW(check_written_mesh(meant, meant));
    Mesh found = meant;
    meant.triangles.insert(meant.triangles.begin() + 1, {1, 1, 2});
    meant.texcoords.insert(meant.texcoords.begin() + 3, {{0, 0}, {0, 0}, {1, 1}});
    CHECK_NOTHROW(check_written_mesh(found, meant));
    const auto error = [&](const auto& change)
    {
        Mesh other = found;
        change(other);
        try
        {
            check_written_mesh(other, meant);
        }
        catch (const Error& e)
        {
            return std::string(e.what());
        }
        return std::string();
    };
    CHECK_THAT(error([](Mesh& m) { m.positions[2].x += 1e-7F; }), Catch::Contains("the positions differ"));
    CHECK_THAT(error([](Mesh& m) { m.colors.resize(m.positions.size()); }), Catch::Contains("the vertex colors differ"));
    CHECK_THAT(error([](Mesh& m) { m.triangles[1] = {2, 3, 0}; }), Catch::Contains("triangle 2 is missing or differs"));
    CHECK_THAT(error([](Mesh& m) { m.texcoords[4].y += 0.01F; }), Catch::Contains("triangle 2 has a different texcoord"));
    CHECK_THAT(error([](Mesh& m) { m.texcoords.clear(); }), Catch::Contains("the number of texcoords differs"));
    CHECK_THAT(error(
                   [](Mesh& m)
                   {
                       m.triangles.push_back({0, 1, 2});
                       m.texcoords.resize(m.texcoords.size() + 3);
                   }),
               Catch::Contains("more triangles"));
}

TEST_CASE("linear light is displayed as the step that it came from")
{
    for (int step = 0; step < 256; ++step)
        CHECK(255 * fresco::texturing::displayed(fresco::texturing::to_linear(static_cast<std::uint8_t>(step))) == Approx(step));
    CHECK(fresco::texturing::displayed(-1) == 0);
    CHECK(fresco::texturing::displayed(2) == Approx(1));
}

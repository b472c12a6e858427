#include "catch.h"

#include <fresco/rendering/simplified.h>

#include <algorithm>
#include <cmath>

using namespace fresco;

TEST_CASE("a surface keeps its bends, borders and seams with few faces, and its texcoords")
{
    // A sheet of 1 m x 1 m, bent up by 45° at x = 0.5 m, with ripples of 0.1 mm; two charts meet at y = 0.5 m.
    constexpr std::uint32_t side = 41;
    constexpr std::uint32_t seam = 20;
    const auto height = [](double x, double y) { return std::max(0.0, x - 0.5) + 1e-4 * std::sin(50 * x) * std::sin(70 * y); };
    TexturedMesh sheet;
    sheet.image = Image(Raster8(2, 2, 3, 90));
    for (std::uint32_t row = 0; row < side; ++row)
        for (std::uint32_t column = 0; column < side; ++column)
        {
            const double x = column / (side - 1.0);
            const double y = row / (side - 1.0);
            sheet.mesh.positions.push_back(vec_cast<float>(Vec3d{x, y, height(x, y)}));
        }
    // Each chart is laid out as seen from above, the second one half a texture further up.
    const auto texcoord = [](Vec3f p, bool second) { return Vec2f{p.x / 2, p.y / 2 + (second ? 0.5F : 0.0F)}; };
    for (std::uint32_t row = 0; row + 1 < side; ++row)
        for (std::uint32_t column = 0; column + 1 < side; ++column)
        {
            const std::uint32_t a = row * side + column;
            for (const Triangle& face : {Triangle{a, a + 1, a + side}, Triangle{a + 1, a + side + 1, a + side}})
            {
                sheet.mesh.triangles.push_back(face);
                for (const auto vertex : face)
                    sheet.mesh.texcoords.push_back(texcoord(sheet.mesh.positions[vertex], row >= seam));
            }
        }
    const Mesh few = rendering::simplified(sheet, 0.002).mesh;
    if (few.triangles == sheet.mesh.triangles)
    {
        WARN("not tested: fresco was built without meshoptimizer");
        return;
    }
    CHECK(few.triangles.size() < sheet.mesh.triangles.size() / 10);
    double area = 0;
    for (std::size_t f = 0; f < few.triangles.size(); ++f)
    {
        const auto corner = [&](std::size_t i) { return few.positions[few.triangles[f][i]]; };
        const double middle = (corner(0).y + corner(1).y + corner(2).y) / 3;
        for (std::size_t i = 0; i < 3; ++i)
            CHECK(few.texcoords[3 * f + i] == texcoord(corner(i), middle > 0.5));
        // Each face lies on one side of the bend, and of the seam.
        for (const auto& [axis, at] : {std::pair{&Vec3f::x, 0.5F}, {&Vec3f::y, 0.5F}})
        {
            const auto [least, most] = std::minmax({corner(0).*axis, corner(1).*axis, corner(2).*axis});
            CHECK((least >= at - 0.03F || most <= at + 0.03F));
        }
        area += length(vec_cast<double>(cross(corner(1) - corner(0), corner(2) - corner(0)))) / 2;
    }
    CHECK(area == Approx(0.5 + 0.5 * std::sqrt(2)).epsilon(0.01));
    CHECK(rendering::simplified(sheet, 1e-7).mesh.triangles.size() > sheet.mesh.triangles.size() / 2);
}

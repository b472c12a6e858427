#include "catch.h"
#include "shapes.h"

#include <fresco/geometry/atlas_figures.h>
#include <fresco/testing.h>

#include <algorithm>
#include <array>
#include <cmath>

using namespace fresco;
using namespace fresco::geometry;

namespace
{

/// 4 x 4 squares over [0,1]² meters, laid at uv = (x * sx, y * sy).
Mesh laid_plane(float sx, float sy)
{
    Mesh mesh = shapes::grid(4, [](float, float) { return 0.0F; });
    testing::set_texcoords(mesh, [=](Vec3f p) { return Vec2f{p.x * sx, p.y * sy}; });
    return mesh;
}

/// A cube of 10 cm, its six sides in a row of squares of an eighth of the texture, with gaps.
Mesh laid_cube()
{
    Mesh mesh = shapes::box({0, 0, 0}, {0.1F, 0.1F, 0.1F});
    const std::array<Vec2f, 4> square{Vec2f{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (std::size_t side = 0; side < 6; ++side)
        for (const auto& corners : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}})
            for (const auto c : corners)
                mesh.texcoords.push_back({(static_cast<float>(side) * 1.25F + square[c].x) / 8, square[c].y / 8});
    return mesh;
}

Value figures_of(const Mesh& mesh)
{
    testing::TestRun run;
    report_atlas(run, mesh, 512);
    return run.reported;
}

}  // namespace

TEST_CASE("a plane pulled to twice its length is stretched by hand's measure")
{
    // Singular values from the atlas to the surface: 1/0.8 and 1/0.4; at equal areas 1/sqrt(2) and sqrt(2).
    auto mesh = laid_plane(0.8F, 0.4F);
    const auto figures = figures_of(mesh);
    CHECK(figures.at("stretch_l2").as_double() == Approx(std::sqrt((0.5 + 2) / 2)));
    CHECK(figures.at("stretch_linf").as_double() == Approx(std::sqrt(2.0)));
    CHECK(figures.at("density_variation").as_double() == Approx(0).margin(1e-6));
    CHECK(figures.at("used_share").as_double() == Approx(0.32));
    CHECK(figures.at("outside_corners").as_int() == 0);
    mesh.texcoords[5].x = 1.01F;
    CHECK(figures_of(mesh).at("outside_corners").as_int() == 1);
}

TEST_CASE("a side at half the scale varies the density and one without texels is lost")
{
    auto mesh = laid_cube();
    for (std::size_t corner = 0; corner < 6; ++corner)
        mesh.texcoords[corner] = mesh.texcoords[corner] * 0.5F;
    const auto figures = figures_of(mesh);
    // Densities 1/2 once and 1 five times: mean 11/12, variance 5/6 + 1/24 - (11/12)².
    CHECK(figures.at("density_variation").as_double() == Approx(std::sqrt(0.875 - 121.0 / 144) / (11.0 / 12)));
    CHECK(figures.at("squeezed_share").as_double() == 0);  // 1/4 of the others' texels, but more of the mean's
    CHECK(figures.at("stretch_l2").as_double() == Approx(std::sqrt((5 + 4) / 6.0 * (5.25 / 6))));

    for (std::size_t corner = 0; corner < 6; ++corner)
        mesh.texcoords[corner] = {0.5F, 0.9F};
    const auto lost = figures_of(mesh);
    CHECK(lost.at("lost_faces").as_int() == 2);
    CHECK(lost.at("squeezed_share").as_double() == Approx(1.0 / 6));
}

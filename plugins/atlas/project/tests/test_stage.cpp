#include "catch.h"
#include "known_atlases.h"

#include <fresco/geometry/topology.h>

using namespace fresco;

namespace
{

const char* const type = "atlas.project";

double area(const Mesh& mesh, std::size_t face)
{
    return 0.5 * length(geometry::area_vector(mesh, face));
}

}  // namespace

TEST_CASE("a cube becomes six squares of equal density")
{
    const auto mesh = shapes::box({1, 2, 3}, {2, 2, 2});
    const MadeAtlas made(type, mesh, Value::Map{{"size_px", 512}});
    const auto& atlas = made.mesh;
    CHECK(check_atlas(*atlas, 512, 4).none());
    for (std::size_t f = 0; f < 12; ++f)
        CHECK(texcoord_area(*atlas, f) == Approx(texcoord_area(*atlas, 0)).epsilon(1e-4));
    // Six squares need three rows of side 1/3 at most: 6/9 of the square, less the gutters.
    CHECK(made.reported("used_share") > 0.62);
    CHECK(made.reported("used_share") < 6.0 / 9);
    CHECK(made.reported("charts") == 6);
    // Twelve edges of length 2 between charts, six diagonals inside them.
    CHECK(made.reported("seam_length_m") == Approx(24));
    CHECK(made.reported("seam_length_share") == Approx(24 / (24 + 6 * std::sqrt(8.0))));
    CHECK(made.reported("largest_angle_deg") == Approx(0).margin(1e-3));
    CHECK(made.reported("stretch_l2") == Approx(1).epsilon(1e-4));
    CHECK(made.reported("stretch_linf") == Approx(1).epsilon(1e-3));
    CHECK(made.reported("density_variation") == Approx(0).margin(1e-3));
    // A texel's side: a face of 2 m has used_share / 6 of the texels.
    CHECK(made.reported("texels_per_cm") == Approx(512 * std::sqrt(made.reported("used_share") / 6) / 200));
}

TEST_CASE("a sphere: few charts, no overlap, stretched by the cosine only")
{
    const auto mesh = shapes::sphere(48, 96);
    const MadeAtlas made(type, mesh, Value::Map{{"size_px", 512}});
    const auto& atlas = made.mesh;
    CHECK(made.reported("charts") <= 12);
    CHECK(check_atlas(*atlas, 512, 4).none());
    CHECK(made.reported("used_share") > 0.5);
    // Faces square to the projection are at the charts' scale.
    double scale = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        scale = std::max(scale, texcoord_area(*atlas, f) / area(mesh, f));
    const double largest = made.reported("largest_angle_deg");
    CHECK(largest <= 80);
    double least = 1;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        least = std::min(least, texcoord_area(*atlas, f) / area(mesh, f) / scale);
    CHECK(least == Approx(std::cos(largest * std::numbers::pi / 180)).epsilon(0.01));
}

TEST_CASE("no face exceeds the angle limit where crumbs may not join, which leaves more charts")
{
    const auto mesh = shapes::noisy_corner(60);
    const MadeAtlas made(type, mesh, Value::Map{{"size_px", 1024}});
    CHECK(check_atlas(*made.mesh, 1024, 4).none());
    CHECK(MadeAtlas(type, mesh, Value::Map{{"size_px", 1024}}, 1).mesh->texcoords == made.mesh->texcoords);
    CHECK(made.reported("charts") < 300);
    CHECK(made.reported("used_share") > 0.6);
    CHECK(made.reported("largest_angle_deg") <= 80.001);
    CHECK(made.reported("largest_angle_deg") > 70.001);
    const MadeAtlas strict(type, mesh, Value::Map{{"size_px", 1024}, {"merge_limit_deg", 70}});
    CHECK(check_atlas(*strict.mesh, 1024, 4).none());
    CHECK(strict.reported("charts") > made.reported("charts"));
    CHECK(strict.reported("largest_angle_deg") <= 70.001);
}

TEST_CASE("limits that contradict each other are refused")
{
    CHECK_THROWS_WITH(MadeAtlas(type, shapes::box({0, 0, 0}, {1, 1, 1}), Value::Map{{"angle_limit_deg", 85}}),
                      Catch::Contains("merge_limit_deg"));
}

TEST_CASE("known meshes: every face keeps its place, and the report lists their faults")
{
    check_known_atlases(type);
}

#include "catch.h"
#include "known_atlases.h"

#include <fresco/geometry/topology.h>

#include <set>

using fresco::Mesh;

namespace
{

std::shared_ptr<Mesh> atlas_of(const Mesh& mesh, const fresco::Value& options, fresco::testing::TestRun& run)
{
    return made_atlas(FRESCO_PLUGIN_FILE, "atlas.project", mesh, options, run);
}

std::size_t chart_count(const Mesh& mesh)
{
    return std::set<std::uint32_t>(mesh.charts.begin(), mesh.charts.end()).size();
}

double area(const Mesh& mesh, std::size_t face)
{
    return 0.5 * fresco::length(fresco::geometry::area_vector(mesh, face));
}

}  // namespace

TEST_CASE("a cube becomes six squares of equal density")
{
    fresco::testing::TestRun run;
    const auto mesh = shapes::box({1, 2, 3}, {2, 2, 2});
    const auto atlas = atlas_of(mesh, fresco::Value::Map{{"size_px", 512}}, run);
    CHECK(atlas->positions == mesh.positions);
    CHECK(atlas->triangles == mesh.triangles);
    CHECK(chart_count(*atlas) == 6);
    CHECK(check_atlas(*atlas, 512, 4).none());
    for (std::size_t f = 0; f < 12; ++f)
    {
        CHECK(texcoord_area(*atlas, f) == Approx(texcoord_area(*atlas, 0)).epsilon(1e-4));
        CHECK(texcoord_area(*atlas, f) > 0);  // not mirrored
    }
    // Six squares need three rows of side 1/3 at most: 6/9 of the square, less the gutters.
    CHECK(run.reported.at("used_share").as_double() > 0.62);
    CHECK(run.reported.at("used_share").as_double() < 6.0 / 9);
    CHECK(run.reported.at("charts").as_int() == 6);
    // Twelve edges of length 2 between charts, six diagonals inside them.
    CHECK(run.reported.at("seam_length_m").as_double() == Approx(24));
    CHECK(run.reported.at("seam_length_share").as_double() == Approx(24 / (24 + 6 * std::sqrt(8.0))));
    CHECK(run.reported.at("largest_angle_deg").as_double() == Approx(0).margin(1e-3));
    CHECK(run.reported.at("stretch_l2").as_double() == Approx(1).epsilon(1e-4));
    CHECK(run.reported.at("stretch_linf").as_double() == Approx(1).epsilon(1e-3));
    CHECK(run.reported.at("density_variation").as_double() == Approx(0).margin(1e-3));
    CHECK(run.reported.at("components").as_int() == 1);
    CHECK(run.reported.at("complex_edges").as_int() == 0);
    // A texel's side: a face of 2 m has used_share / 6 of the texels.
    CHECK(run.reported.at("texels_per_cm").as_double() ==
          Approx(512 * std::sqrt(run.reported.at("used_share").as_double() / 6) / 200));
}

TEST_CASE("a sphere: few charts, no overlap, stretched by the cosine only")
{
    fresco::testing::TestRun run;
    const auto mesh = shapes::sphere(48, 96);
    const auto atlas = atlas_of(mesh, fresco::Value::Map{{"size_px", 512}, {"gutter_px", 2}}, run);
    CHECK(chart_count(*atlas) <= 12);
    CHECK(check_atlas(*atlas, 512, 2).none());
    CHECK(run.reported.at("used_share").as_double() > 0.5);
    // What the projection sees head-on is at the charts' scale.
    double scale = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        scale = std::max(scale, texcoord_area(*atlas, f) / area(mesh, f));
    const double largest = run.reported.at("largest_angle_deg").as_double();
    CHECK(largest <= 80);
    double least = 1;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const double cosine = texcoord_area(*atlas, f) / area(mesh, f) / scale;
        least = std::min(least, cosine);
    }
    CHECK(least == Approx(std::cos(largest * std::numbers::pi / 180)).epsilon(0.01));
}

TEST_CASE("a noisy room corner: everything holds at once")
{
    fresco::testing::TestRun run(2);
    const auto mesh = shapes::noisy_corner(60);
    const auto atlas = atlas_of(mesh, fresco::Value::Map{{"size_px", 1024}}, run);
    CHECK(check_atlas(*atlas, 1024, 4).none());
    CHECK(chart_count(*atlas) < 300);
    CHECK(run.reported.at("used_share").as_double() > 0.6);

    SECTION("no face exceeds the angle limit where crumbs may not join, which leaves more charts")
    {
        fresco::testing::TestRun strict;
        const auto apart = atlas_of(mesh, fresco::Value::Map{{"size_px", 1024}, {"merge_limit_deg", 70}}, strict);
        CHECK(check_atlas(*apart, 1024, 4).none());
        CHECK(chart_count(*apart) > chart_count(*atlas));
        CHECK(strict.reported.at("largest_angle_deg").as_double() <= 70.001);
        CHECK(run.reported.at("largest_angle_deg").as_double() <= 80.001);
        CHECK(run.reported.at("largest_angle_deg").as_double() > 70.001);
    }
}

TEST_CASE("limits that contradict each other are refused")
{
    fresco::testing::TestRun run;
    CHECK_THROWS_WITH(atlas_of(shapes::box({0, 0, 0}, {1, 1, 1}), fresco::Value::Map{{"angle_limit_deg", 85}}, run),
                      Catch::Contains("merge_limit_deg"));
}

TEST_CASE("known meshes: every face keeps its place, and the report lists their faults")
{
    check_known_atlases(FRESCO_PLUGIN_FILE, "atlas.project");
}

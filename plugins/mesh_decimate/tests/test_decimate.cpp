#include "decimate.h"
#include "known_simplifications.h"

#include <fresco/error.h>
#include <fresco/geometry/repair.h>
#include <fresco/geometry/topology.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <cmath>

using fresco::Mesh;
using fresco::geometry::count_surface;

namespace
{

Mesh decimate(const Mesh& mesh, std::size_t faces, std::size_t piece_faces = 32768, int threads = 2)
{
    fresco::testing::TestRun progress(threads);
    fresco::geometry::RepairReport report;
    return decimated(fresco::geometry::repaired(mesh, report, progress), {.max_faces = faces, .piece_faces = piece_faces},
                     progress);
}

float bump(float x, float y)
{
    return 0.2F * std::exp(-20 * ((x - 0.5F) * (x - 0.5F) + (y - 0.5F) * (y - 0.5F)));
}

/// The largest vertical distance of the faces' middles to the bump.
float farthest(const Mesh& mesh)
{
    float most = 0;
    for (const auto& t : mesh.triangles)
    {
        fresco::Vec3f center{};
        for (const auto v : t)
            center += mesh.positions[v] * (1.0F / 3);
        most = std::max(most, std::abs(center.z - bump(center.x, center.y)));
    }
    return most;
}

}  // namespace

TEST_CASE("a flat square keeps its outline, its area and its colors")
{
    auto mesh = shapes::grid(20, [](float, float) { return 0.0F; });
    for (const auto& p : mesh.positions)
        mesh.colors.push_back(p.x < 0.5F ? fresco::Rgb8{200, 0, 0} : fresco::Rgb8{0, 0, 100});
    for (const std::size_t piece_faces : {64, 100000})
    {
        const auto out = decimate(mesh, 100, piece_faces);
        const auto counts = count_surface(out);
        CHECK(counts.faces <= 100);
        CHECK(counts.faces >= 98);
        CHECK(counts.area_m2 == Approx(1).margin(1e-5));
        CHECK(counts.border_length_m == Approx(4).margin(1e-5));
        CHECK(counts.components == 1);
        for (const auto& n : fresco::face_normals(out))
            CHECK(n.z == Approx(1));
        // Means of two colors lie between them.
        REQUIRE(out.colors.size() == out.positions.size());
        for (const auto& color : out.colors)
        {
            CHECK(color[1] == 0);
            CHECK(int(color[0]) + 2 * int(color[2]) == Approx(200).margin(2));
        }
    }
}

TEST_CASE("a bump stays where it is, cut into pieces as well as whole")
{
    const auto mesh = shapes::grid(80, bump);
    const auto pieces = decimate(mesh, 600, 500);
    const auto whole = decimate(mesh, 600);
    for (const auto* out : {&pieces, &whole})
    {
        CHECK(out->triangles.size() <= 600);
        CHECK(out->triangles.size() >= 596);
        CHECK(count_surface(*out).border_length_m == Approx(count_surface(mesh).border_length_m).epsilon(0.002));
        CHECK(count_surface(*out).complex_edges == 0);
        CHECK(farthest(*out) < 0.006F);
    }
}

TEST_CASE("the result does not depend on threads")
{
    const auto mesh = shapes::noisy_corner(40);
    const auto one = decimate(mesh, 3000, 700, 1);
    for (const int threads : {2, 5})
    {
        const auto many = decimate(mesh, 3000, 700, threads);
        CHECK(one.positions == many.positions);
        CHECK(one.triangles == many.triangles);
    }
}

TEST_CASE("what a surface is stays: components, holes, borders")
{
    Mesh mesh = shapes::grid(8, [](float, float) { return 0.0F; });
    shapes::append(mesh, shapes::box({5, 0, 0}, {1, 1, 1}));
    shapes::append(mesh, shapes::sphere(10, 12));
    for (int i = 0; i < 2000; ++i)  // crumbs
    {
        Mesh crumb;
        const auto x = static_cast<float>(i);
        crumb.positions = {{x, 9, 0}, {x + 0.5F, 9, 0}, {x, 9.5F, 0}};
        crumb.triangles = {{0, 1, 2}};
        shapes::append(mesh, crumb);
    }
    const auto before = count_surface(mesh);
    for (const std::size_t piece_faces : {64, 100000})
    {
        const auto out = decimate(mesh, 4, piece_faces);
        const auto after = count_surface(out);
        CHECK(after.components == before.components);
        CHECK(after.complex_edges == 0);
        CHECK(after.faces >= 2000 + 4 + 4 + 1);
        CHECK(after.faces <= 2000 + 30);
    }
}

TEST_CASE("the stage gives the core's mesh, reports, warns and can be stopped")
{
    auto mesh =
        std::make_shared<Mesh>(shapes::grid(100, [](float x, float y) { return 0.05F * std::sin(20 * x) * std::cos(15 * y); }));
    mesh->triangles.push_back({0, 1, 1});
    mesh->triangles.push_back(mesh->triangles[7]);
    mesh->texcoords.resize(mesh->triangles.size() * 3);
    const auto run_once = [&](int faces, fresco::testing::TestRun& run)
    {
        auto stage = fresco::testing::make_from_plugin(FRESCO_PLUGIN_FILE, "mesh.decimate");
        fresco::testing::TemporaryFolder folder;
        fresco::testing::TestFactory factory;
        fresco::testing::run_stage(dynamic_cast<fresco::Stage&>(*stage), fresco::Value::Map{{"max_faces", faces}},
                                   {{"mesh", mesh}}, folder.path(), run, factory);
        return Mesh::load({folder.path() / "simplified", {}});
    };
    fresco::testing::TestRun run(2);
    const auto out = run_once(5000, run);
    CHECK(out->triangles == decimate(*mesh, 5000).triangles);
    CHECK(out->texcoords.empty());
    CHECK(out->triangles.size() <= 5000);
    CHECK(run.reported.at("degenerate_faces_removed").as_int() == 1);
    CHECK(run.reported.at("duplicate_faces_removed").as_int() == 1);
    CHECK(run.reported.at("faces_before").as_int() == 20002);
    CHECK(run.reported.at("faces_after").as_int() == static_cast<std::int64_t>(out->triangles.size()));

    fresco::testing::TestRun untouched;
    CHECK(run_once(20000, untouched)->triangles.size() == 20000);

    fresco::testing::TestRun stopped;
    stopped.cancel_after(6);
    CHECK_THROWS_AS(run_once(5000, stopped), fresco::Canceled);

    // Five separate triangles cannot become four.
    mesh = std::make_shared<Mesh>();
    for (int i = 0; i < 5; ++i)
    {
        Mesh crumb;
        const auto z = static_cast<float>(i);
        crumb.positions = {{0, 0, z}, {1, 0, z}, {0, 1, z}};
        crumb.triangles = {{0, 1, 2}};
        shapes::append(*mesh, crumb);
    }
    fresco::testing::TestRun stuck;
    CHECK(run_once(4, stuck)->triangles.size() == 5);
    REQUIRE_FALSE(stuck.messages.empty());
    CHECK(stuck.messages.back().find("warning: stopped at 5 faces instead of 4") == 0);
}

TEST_CASE("known meshes: repaired with a count, no component lost, no hole or handle closed")
{
    check_known_simplifications(FRESCO_PLUGIN_FILE, "mesh.decimate");
}

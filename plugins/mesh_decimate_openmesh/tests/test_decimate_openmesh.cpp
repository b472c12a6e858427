#include "decimate_openmesh.h"
#include "known_simplifications.h"

#include <fresco/geometry/topology.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <cmath>

using fresco::Mesh;
using fresco::geometry::count_surface;

namespace
{

/// Half of it red, half of it blue.
template <class Height>
Mesh grid(std::uint32_t n, Height height)
{
    Mesh mesh = shapes::grid(n, height);
    for (const auto& p : mesh.positions)
        mesh.colors.push_back(p.x < 0.5F ? fresco::Rgb8{200, 0, 0} : fresco::Rgb8{0, 0, 100});
    return mesh;
}

Mesh decimate(const Mesh& mesh, std::size_t faces)
{
    fresco::Progress progress;
    return decimated_openmesh(mesh, faces, progress);
}

}  // namespace

TEST_CASE("a flat square keeps its outline, its area and its colors")
{
    const auto mesh = grid(20, [](float, float) { return 0.0F; });
    const auto out = decimate(mesh, 100);
    const auto counts = count_surface(out);
    CHECK(counts.faces <= 100);
    CHECK(counts.faces >= 98);
    CHECK(counts.area_m2 == Approx(1).margin(1e-9));
    CHECK(counts.border_length_m == Approx(4).margin(1e-9));
    CHECK(counts.components == 1);
    for (const auto& n : fresco::face_normals(out))
        CHECK(n.z == Approx(1));
    // Means of two colors lie between them; far from the line where they meet they are pure.
    REQUIRE(out.colors.size() == out.positions.size());
    for (std::size_t v = 0; v < out.colors.size(); ++v)
    {
        CHECK(out.colors[v][1] == 0);
        CHECK(int(out.colors[v][0]) + 2 * int(out.colors[v][2]) == Approx(200).margin(2));
    }
}

TEST_CASE("a bump stays where it is: the surface moves less than its noise")
{
    const auto height = [](float x, float y)
    { return 0.2F * std::exp(-20 * ((x - 0.5F) * (x - 0.5F) + (y - 0.5F) * (y - 0.5F))); };
    const auto out = decimate(grid(60, height), 600);
    CHECK(out.triangles.size() <= 600);
    CHECK(count_surface(out).border_length_m == Approx(count_surface(grid(60, height)).border_length_m).epsilon(0.002));
    for (const auto& t : out.triangles)
    {
        fresco::Vec3f center{};
        for (const auto v : t)
            center += out.positions[v] * (1.0F / 3);
        CHECK(std::abs(center.z - height(center.x, center.y)) < 0.006F);
    }
}

TEST_CASE("every component survives any target")
{
    Mesh mesh = grid(4, [](float, float) { return 0.0F; });
    mesh.colors.clear();
    const auto first = mesh;
    for (int copy = 1; copy < 5; ++copy)
    {
        const auto n = static_cast<std::uint32_t>(mesh.positions.size());
        for (const auto& p : first.positions)
            mesh.positions.push_back({p.x, p.y, p.z + static_cast<float>(copy)});
        for (const auto& t : first.triangles)
            mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    }
    const auto n = static_cast<std::uint32_t>(mesh.positions.size());  // and a closed one: an octahedron
    for (const fresco::Vec3f p : {fresco::Vec3f{1, 0, 9}, {0, 1, 9}, {-1, 0, 9}, {0, -1, 9}, {0, 0, 10}, {0, 0, 8}})
        mesh.positions.push_back(p);
    for (std::uint32_t k = 0; k < 4; ++k)
    {
        mesh.triangles.push_back({n + k, n + (k + 1) % 4, n + 4});
        mesh.triangles.push_back({n + (k + 1) % 4, n + k, n + 5});
    }
    const auto out = decimate(mesh, 4);
    CHECK(count_surface(out).components == 6);
    CHECK(out.triangles.size() >= 9);
    CHECK(out.triangles.size() <= 18);
    CHECK(count_surface(out).complex_edges == 0);
}

TEST_CASE("the stage reports, warns, repeats itself bit by bit and can be stopped")
{
    const auto make = []
    {
        auto made = fresco::testing::make_from_plugin(FRESCO_PLUGIN_FILE, "mesh.decimate_openmesh");
        REQUIRE(dynamic_cast<fresco::Stage*>(made.get()) != nullptr);
        return made;
    };
    auto mesh = std::make_shared<Mesh>(grid(100, [](float x, float y) { return 0.05F * std::sin(20 * x) * std::cos(15 * y); }));
    mesh->triangles.push_back({0, 1, 1});
    mesh->triangles.push_back(mesh->triangles[7]);
    mesh->texcoords.resize(mesh->triangles.size() * 3);

    const auto run_once = [&](int faces, fresco::testing::TestRun& run)
    {
        auto stage = make();
        fresco::testing::TemporaryFolder folder;
        fresco::testing::TestFactory factory;
        fresco::testing::run_stage(dynamic_cast<fresco::Stage&>(*stage), fresco::Value::Map{{"max_faces", faces}},
                                   {{"mesh", mesh}}, folder.path(), run, factory);
        return Mesh::load({folder.path() / "simplified", {}});
    };
    fresco::testing::TestRun one(1);
    const auto a = run_once(5000, one);
    fresco::testing::TestRun two(4);
    const auto b = run_once(5000, two);
    CHECK(a->positions == b->positions);
    CHECK(a->triangles == b->triangles);
    CHECK(a->colors == b->colors);
    CHECK(a->texcoords.empty());
    CHECK(a->triangles.size() <= 5000);
    CHECK(one.reported.at("degenerate_faces_removed").as_int() == 1);
    CHECK(one.reported.at("duplicate_faces_removed").as_int() == 1);
    CHECK(one.reported.at("faces_before").as_int() == 20002);
    CHECK(one.reported.at("faces_after").as_int() == static_cast<std::int64_t>(a->triangles.size()));
    CHECK(one.reported.at("components_after").as_int() == 1);

    fresco::testing::TestRun untouched;
    CHECK(run_once(20000, untouched)->triangles.size() == 20000);

    fresco::testing::TestRun small;
    const auto smallest = run_once(4, small)->triangles.size();
    CHECK(smallest >= 3);  // a collapse takes at most two, so it stops at four or three
    CHECK(smallest <= 4);
    fresco::testing::TestRun stopped;
    stopped.cancel_after(4);
    CHECK_THROWS_AS(run_once(5000, stopped), fresco::Canceled);

    // Five separate triangles cannot become four.
    mesh = std::make_shared<Mesh>();
    for (std::uint32_t i = 0; i < 15; i += 3)
    {
        const auto z = static_cast<float>(i);
        mesh->positions.insert(mesh->positions.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
        mesh->triangles.push_back({i, i + 1, i + 2});
    }
    fresco::testing::TestRun stuck;
    CHECK(run_once(4, stuck)->triangles.size() == 5);
    REQUIRE_FALSE(stuck.messages.empty());
    CHECK(stuck.messages.back().find("warning: stopped at 5 faces instead of 4") == 0);
}

TEST_CASE("known meshes: repaired with a count, no component lost, no hole or handle closed")
{
    check_known_simplifications(FRESCO_PLUGIN_FILE, "mesh.decimate_openmesh");
}

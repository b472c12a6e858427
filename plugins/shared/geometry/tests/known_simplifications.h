#pragma once

#include "catch.h"
#include "known_meshes.h"
#include "shapes.h"

#include <fresco/error.h>
#include <fresco/geometry/topology.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>

/// \file What every simplification, and every stage that does it, must hold.

namespace simplification
{

using fresco::Mesh;
using fresco::geometry::count_surface;
using fresco::testing::TestRun;

/// shapes::grid, its left half red and its right half blue.
template <class Height>
Mesh two_colored_grid(std::uint32_t n, Height height)
{
    Mesh mesh = shapes::grid(n, height);
    for (const auto& p : mesh.positions)
        mesh.colors.push_back(p.x < 0.5F ? fresco::Rgb8{200, 0, 0} : fresco::Rgb8{0, 0, 100});
    return mesh;
}

inline Mesh flat_square()
{
    return two_colored_grid(20, [](float, float) { return 0.0F; });
}

/// Checks flat_square() in 100 faces.
inline void check_flat_square(const Mesh& out, double margin)
{
    const auto counts = count_surface(out);
    CHECK(counts.faces <= 100);
    CHECK(counts.faces >= 98);
    CHECK(counts.area_m2 == Approx(1).margin(margin));
    CHECK(counts.border_length_m == Approx(4).margin(margin));
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

inline float bump(float x, float y)
{
    return 0.2F * std::exp(-20 * ((x - 0.5F) * (x - 0.5F) + (y - 0.5F) * (y - 0.5F)));
}

/// Checks `mesh`, a grid at the height of the bump, in 600 faces.
inline void check_bump(const Mesh& out, const Mesh& mesh)
{
    CHECK(out.triangles.size() <= 600);
    CHECK(out.triangles.size() >= 596);
    CHECK(count_surface(out).border_length_m == Approx(count_surface(mesh).border_length_m).epsilon(0.002));
    CHECK(count_surface(out).complex_edges == 0);
    float farthest = 0;
    for (const auto& t : out.triangles)
    {
        fresco::Vec3f center{};
        for (const auto v : t)
            center += out.positions[v] * (1.0F / 3);
        farthest = std::max(farthest, std::abs(center.z - bump(center.x, center.y)));
    }
    CHECK(farthest < 0.006F);
}

/// A simplifying stage of a built plugin.
struct SimplifyingStage
{
    const char* plugin_file;
    const char* type;

    std::shared_ptr<const Mesh> operator()(const Mesh& mesh, int faces, TestRun& run) const
    {
        fresco::testing::TemporaryFolder folder;
        fresco::testing::run_stage(plugin_file, type, fresco::Value::Map{{"max_faces", faces}},
                                   {{"mesh", std::make_shared<Mesh>(mesh)}}, folder.path(), run);
        return Mesh::load({folder.path() / "simplified", {}});
    }
};

/// A wavy square of 20 000 faces, and two that repairing removes.
inline Mesh waves()
{
    Mesh mesh = two_colored_grid(100, [](float x, float y) { return 0.05F * std::sin(20 * x) * std::cos(15 * y); });
    mesh.triangles.push_back({0, 1, 1});
    mesh.triangles.push_back(mesh.triangles[7]);
    mesh.texcoords.resize(mesh.triangles.size() * 3);
    return mesh;
}

/// It reports, can be stopped, and warns if it cannot reach what was asked for.
inline void check_stage(const SimplifyingStage& simplified)
{
    TestRun one(1);
    const auto out = simplified(waves(), 5000, one);
    CHECK(out->texcoords.empty());
    CHECK(out->triangles.size() <= 5000);
    const auto reported = [&](const char* key) { return one.reported.at(key).as_int(); };
    CHECK(reported("degenerate_faces_removed") == 1);
    CHECK(reported("duplicate_faces_removed") == 1);
    CHECK(reported("faces_before") == 20002);
    CHECK(reported("faces_after") == std::ssize(out->triangles));
    CHECK(reported("components_after") == 1);

    TestRun untouched;
    CHECK(simplified(waves(), 20000, untouched)->triangles.size() == 20000);

    TestRun stopped;
    stopped.cancel_after(4);
    CHECK_THROWS_AS(simplified(waves(), 5000, stopped), fresco::Canceled);

    // Five separate triangles cannot become four.
    Mesh crumbs;
    for (std::uint32_t i = 0; i < 15; i += 3)
    {
        const auto z = static_cast<float>(i);
        crumbs.positions.insert(crumbs.positions.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
        crumbs.triangles.push_back({i, i + 1, i + 2});
    }
    TestRun stuck;
    CHECK(simplified(crumbs, 4, stuck)->triangles.size() == 5);
    REQUIRE_FALSE(stuck.messages.empty());
    CHECK(stuck.messages.back().find("warning: stopped at 5 faces instead of 4") == 0);
}

/// Every known mesh comes out manifold, with its components, holes and handles, and the report lists what was repaired.
inline void check_known_meshes(const SimplifyingStage& simplified)
{
    for (const auto& known : known_meshes())
        for (const int faces : {4, 500})
        {
            INFO(known.name << " to " << faces);
            TestRun run(2);
            const auto out = simplified(known.mesh, faces, run);
            const auto reported = [&](const char* key) { return run.reported.at(key).as_int(); };
            CHECK(reported("components_before") == known.components);
            CHECK(reported("components_after") == known.repaired_components);
            CHECK(reported("duplicate_faces_removed") == known.duplicate_faces);
            CHECK(reported("degenerate_faces_removed") == known.degenerate_faces);
            CHECK(reported("complex_edges_repaired") == known.repaired_edges);
            const auto counts = count_surface(*out);
            CHECK(counts.complex_edges == 0);
            CHECK(static_cast<long>(counts.vertices) - static_cast<long>(counts.edges) + static_cast<long>(counts.faces) ==
                  known.euler);
            // A face that is there twice counts once.
            const double area = count_surface(known.mesh).area_m2 * (known.duplicate_faces > 0 ? 12.0 / 13 : 1);
            CHECK(counts.area_m2 > (faces > 100 ? 0.9 : 0.2) * area);
        }
}

}  // namespace simplification

#pragma once

#include "atlas_check.h"
#include "catch.h"
#include "known_meshes.h"

#include <fresco/geometry/topology.h>
#include <fresco/testing.h>

/// The mesh that an atlas stage makes of this one.
inline std::shared_ptr<fresco::Mesh> made_atlas(const char* plugin_file, const char* type, const fresco::Mesh& mesh,
                                                const fresco::Value& options, fresco::testing::TestRun& run)
{
    fresco::testing::TemporaryFolder folder;
    fresco::testing::run_stage(plugin_file, type, options, {{"mesh", std::make_shared<fresco::Mesh>(mesh)}}, folder.path(), run);
    return fresco::Mesh::load({folder.path() / "atlas", {}});
}

/// Every known mesh keeps its faces, each with area has texels that no other face shares, and the report lists its faults.
inline void check_known_atlases(const char* plugin_file, const char* type)
{
    for (const auto& known : known_meshes())
    {
        INFO(known.name);
        fresco::testing::TestRun run(2);
        const auto atlas =
            made_atlas(plugin_file, type, known.mesh, fresco::Value::Map{{"size_px", 1024}, {"gutter_px", 2}}, run);
        CHECK(atlas->texture_px == 1024);
        CHECK(atlas->positions == known.mesh.positions);
        CHECK(atlas->triangles == known.mesh.triangles);
        CHECK(check_atlas(*atlas, 1024, 2).none());
        for (std::size_t f = 0; f < known.mesh.triangles.size(); ++f)
            CHECK((texcoord_area(*atlas, f) > 0) == (length(fresco::geometry::area_vector(known.mesh, f)) > 0));
        const auto reported = [&](const char* key) { return run.reported.at(key).as_int(); };
        CHECK(reported("components") == known.components);
        CHECK(reported("duplicate_faces") == known.duplicate_faces);
        CHECK(reported("degenerate_faces") == known.degenerate_faces);
        CHECK(reported("complex_edges") == known.complex_edges);
        CHECK(reported("lost_faces") == 0);
        CHECK(reported("charts") >= known.components);
    }
}

/// A noisy corner is nearly all mapped without overlap, and the thread count does not matter.
inline void check_noisy_corner_atlas(const char* plugin_file, const char* type)
{
    const auto mesh = shapes::noisy_corner(30);
    const fresco::Value options = fresco::Value::Map{{"size_px", 512}};
    fresco::testing::TestRun two(2);
    const auto atlas = made_atlas(plugin_file, type, mesh, options, two);
    CHECK(check_atlas(*atlas, 512, 4).none());
    CHECK(two.reported.at("mapped_area_share").as_double() > 0.8);
    fresco::testing::TestRun one(1);
    CHECK(made_atlas(plugin_file, type, mesh, options, one)->texcoords == atlas->texcoords);
}

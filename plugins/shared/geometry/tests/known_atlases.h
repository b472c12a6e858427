#pragma once

#include "atlas_check.h"
#include "catch.h"
#include "known_meshes.h"
#include "plugin_under_test.h"

#include <fresco/geometry/topology.h>

/// Result of the atlas stage under test.
struct MadeAtlas
{
    fresco::testing::TestRun run;
    std::shared_ptr<fresco::Mesh> mesh;

    MadeAtlas(const char* type, const fresco::Mesh& from, const fresco::Value& options = fresco::Value::Map{}, int threads = 2)
        : run(threads)
    {
        mesh = fresco::testing::output_of<fresco::Mesh>(type, "atlas", options, {{"mesh", std::make_shared<fresco::Mesh>(from)}},
                                                        run);
    }

    double reported(const char* key) const { return run.reported.at(key).as_double(); }
};

/// Every known mesh keeps its faces, each with area has texels that no other face shares, and the report lists its faults.
inline void check_known_atlases(const char* type)
{
    for (const auto& known : known_meshes())
    {
        INFO(known.name);
        const MadeAtlas made(type, known.mesh, fresco::Value::Map{{"size_px", 1024}});
        const auto& atlas = made.mesh;
        CHECK(atlas->texture_px == 1024);
        CHECK(atlas->positions == known.mesh.positions);
        CHECK(atlas->triangles == known.mesh.triangles);
        CHECK(check_atlas(*atlas, 1024, 4).none());
        for (std::size_t f = 0; f < known.mesh.triangles.size(); ++f)
            CHECK((texcoord_area(*atlas, f) > 0) == (length(fresco::geometry::area_vector(known.mesh, f)) > 0));
        CHECK(made.reported("components") == known.components);
        CHECK(made.reported("duplicate_faces") == known.duplicate_faces);
        CHECK(made.reported("degenerate_faces") == known.degenerate_faces);
        CHECK(made.reported("complex_edges") == known.complex_edges);
        CHECK(made.reported("lost_faces") == 0);
        CHECK(made.reported("charts") >= known.components);
    }
}

#pragma once

#include "known_meshes.h"

#include <fresco/geometry/topology.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

/// Every known mesh comes out of a simplifying stage manifold, with its components, holes and handles, and the report tells what
/// was repaired.
inline void check_known_simplifications(const char* plugin_file, const char* type)
{
    using fresco::geometry::count_surface;
    for (const auto& known : known_meshes())
        for (const int faces : {4, 500})
        {
            INFO(known.name << " to " << faces);
            const auto stage = fresco::testing::make_from_plugin(plugin_file, type);
            fresco::testing::TemporaryFolder folder;
            fresco::testing::TestFactory factory;
            fresco::testing::TestRun run(2);
            fresco::testing::run_stage(dynamic_cast<fresco::Stage&>(*stage), fresco::Value::Map{{"max_faces", faces}},
                                       {{"mesh", std::make_shared<fresco::Mesh>(known.mesh)}}, folder.path(), run, factory);
            const auto out = fresco::Mesh::load({folder.path() / "simplified", {}});
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

#pragma once

#include "shapes.h"

#include <string>
#include <vector>

/// \file Meshes whose shape and faults are known, for the tests of every stage that takes one.

struct KnownMesh
{
    std::string name;
    fresco::Mesh mesh;
    int components = 1;           ///< Sets of faces connected through edges.
    int repaired_components = 1;  ///< Components once every edge has two faces of one orientation at most.
    int duplicate_faces = 0;
    int degenerate_faces = 0;
    int complex_edges = 0;   ///< Edges of three or more faces, or of two that disagree.
    int repaired_edges = 0;  ///< Such edges once duplicate and degenerate faces are removed.
    long euler = 2;          ///< Vertices - edges + faces, once repaired.
};

inline std::vector<KnownMesh> known_meshes()
{
    using shapes::box;
    std::vector<KnownMesh> all;
    all.push_back({.name = "cube", .mesh = box({0, 0, 0}, {1, 1, 1})});
    all.push_back({.name = "sphere", .mesh = shapes::sphere(24, 48)});
    all.push_back({.name = "torus", .mesh = shapes::torus(24), .euler = 0});
    all.push_back(
        {.name = "Moebius strip", .mesh = shapes::moebius_strip(60), .complex_edges = 1, .repaired_edges = 1, .euler = 1});

    KnownMesh boxes{.name = "two boxes that touch in an edge", .mesh = box({0, 0, 0}, {1, 1, 1})};
    auto second = box({1, 1, 0}, {1, 1, 1});
    for (const auto& t : second.triangles)
    {
        // Vertices 0 and 4 of the second are 3 and 7 of the first.
        const auto at = [](std::uint32_t v) { return v == 0 ? 3 : v == 4 ? 7 : v + 8; };
        boxes.mesh.triangles.push_back({at(t[0]), at(t[1]), at(t[2])});
    }
    boxes.mesh.positions.insert(boxes.mesh.positions.end(), second.positions.begin(), second.positions.end());
    boxes.repaired_components = 2;
    boxes.complex_edges = boxes.repaired_edges = 1;
    boxes.euler = 4;
    all.push_back(boxes);

    KnownMesh loose{
        .name = "10 000 loose components", .mesh = {}, .components = 10'000, .repaired_components = 10'000, .euler = 10'000};
    for (int i = 0; i < 10'000; ++i)
    {
        fresco::Mesh one;
        const auto x = static_cast<float>(i % 100);
        const auto y = static_cast<float>(i / 100);
        one.positions = {{x, y, 0}, {x + 0.5F, y, 0}, {x, y + 0.5F, 0.1F}};
        one.triangles = {{0, 1, 2}};
        shapes::append(loose.mesh, one);
    }
    all.push_back(loose);

    KnownMesh twice{.name = "a face twice", .mesh = box({0, 0, 0}, {1, 1, 1}), .duplicate_faces = 1, .complex_edges = 3};
    twice.mesh.triangles.push_back(twice.mesh.triangles[4]);
    all.push_back(twice);

    KnownMesh flat{.name = "faces without area", .mesh = box({0, 0, 0}, {1, 1, 1}), .degenerate_faces = 2, .complex_edges = 1};
    flat.mesh.positions.push_back({0.5F, 0, 0});
    flat.mesh.triangles.push_back({0, 1, 1});
    flat.mesh.triangles.push_back({0, 1, 8});
    all.push_back(flat);

    KnownMesh turned{.name = "a face turned over",
                     .mesh = box({0, 0, 0}, {1, 1, 1}),
                     .repaired_components = 2,
                     .complex_edges = 3,
                     .repaired_edges = 3};
    std::swap(turned.mesh.triangles[0][0], turned.mesh.triangles[0][1]);
    all.push_back(turned);  // the hole and the face alone have Euler's number 1 each

    KnownMesh fin{.name = "a fin on an edge",
                  .mesh = box({0, 0, 0}, {1, 1, 1}),
                  .repaired_components = 2,
                  .complex_edges = 1,
                  .repaired_edges = 1};
    fin.mesh.positions.push_back({0.5F, -1, -1});
    fin.mesh.triangles.push_back({0, 1, 8});
    all.push_back(fin);  // continues one side better than the box does: a box with a hole and a fin, and the face of the hole
    return all;
}

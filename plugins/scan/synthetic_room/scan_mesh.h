#pragma once

#include "light.h"
#include "scene.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <atomic>
#include <vector>

/// \file The mesh of the generated room as a scanner would make it, and the part of the room that each face shows. The stage
/// stores both as its outputs.

namespace room
{

/// The boundary between air and solids as one connected surface of triangles of about `edge` meters, as depth fusion finds it:
/// bodies that touch grow together, edges are slightly rounded.
struct SurfaceNet
{
    std::vector<Vec3f> positions;             ///< V, on the surface.
    std::vector<Vec3f> normals;               ///< V, unit, into the air.
    std::vector<int> solids;                  ///< V, the solid that each lies on.
    std::vector<fresco::Triangle> triangles;  ///< F, counter-clockwise seen from the air.
};

/// Naive surface nets (Gibson, "Constrained elastic surface nets", MICCAI 1998) on a grid of `edge` meters, each vertex then
/// moved onto the exact surface. Deterministic for any thread count. Throws Error if the grid would have more than 60 million
/// nodes, Canceled.
SurfaceNet surface_net(const Scene& scene, float edge, fresco::Progress& progress);

/// The surface with a scanner's errors: vertices moved along their normals by slow waves and fine noise of about `noise_m`
/// (standard deviation), and colored as the light shows them.
fresco::Mesh noisy_mesh(const SurfaceNet& net, const Scene& scene, const LightMap& light, float edge, float noise_m,
                        std::uint32_t seed, fresco::Progress& progress);

/// V: 1 once the depth camera has seen the vertex.
using SeenVertices = std::vector<std::atomic<char>>;

/// Marks the vertices that a view shows. May be called from several threads at once.
void mark_seen(const std::vector<Vec3f>& positions, const fresco::Raster<float>& exact_depth, const fresco::Camera& camera,
               SeenVertices& seen);

/// The scanned part of the mesh: faces with a seen vertex, without components of fewer than 40 faces. Throws Error if no face is
/// left. `parts`: those of the mesh's faces; afterward those of the remaining faces.
fresco::Mesh seen_part(const fresco::Mesh& mesh, const SeenVertices& seen, std::vector<Part>& parts);

/// F: the exact part of the room that each face shows: that of two of its corners, or of the first.
std::vector<Part> parts_of_faces(const SurfaceNet& net, const Scene& scene);

}  // namespace room

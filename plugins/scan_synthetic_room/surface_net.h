#pragma once

#include "scene.h"

#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <vector>

namespace room
{

/// The boundary between air and everything else as one connected surface of triangles of about `edge` meters, as a scanner's
/// fusion would find it: bodies that touch grow together, edges are slightly rounded.
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

}  // namespace room

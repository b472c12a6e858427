#pragma once

#include <fresco/geometry/topology.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>
#include <fresco/texturing/charts.h>

#include <utility>
#include <vector>

namespace fresco::synthesize
{

/// Directions of a picture that lies on a surface: `right` and `down` as its x and y, `out` toward the viewer. Orthonormal.
struct TangentFrame
{
    Vec3f right, down, out;
};

/// Upward, and a horizontal direction that stands for it where the surface is level. Orthonormal.
struct Upright
{
    Vec3f up, ahead;
};

/// A mesh with an atlas and what laying patches on it asks for. Refers to the mesh, which must outlive it.
struct PaintedSurface
{
    const Mesh& mesh;
    texturing::Charts charts;
    std::vector<double> uv_per_m;   ///< Per chart: texcoords along a meter, from the areas; 0 where it has none.
    geometry::Neighbors neighbors;  ///< F x 3, also across the atlas's seams and between vertices at one position.
    std::vector<Vec3f>
        normals;  ///< F, unit, smoothed over about ten rings of faces, but not over edges; zero for a face without area.

    /// The mesh must have passed check_mesh and have texcoords. Throws Canceled.
    PaintedSurface(const Mesh& of, const Progress& progress);
};

/// Which way u and v run over a face, in meters per texcoord; zero for a face without area in the atlas.
std::pair<Vec3f, Vec3f> texcoord_axes(const Mesh& mesh, std::size_t face);

/// `ahead` is the horizontal direction that most of the surface faces along, from the area-weighted normals; the same for any
/// order of the faces up to rounding.
Upright upright(const PaintedSurface& surface, Vec3f up);

/// How a picture hangs there: its top is up on walls and slopes, and points ahead on what is within 45 degrees of level.
TangentFrame frame_at(Vec3f normal, const Upright& upright);

}  // namespace fresco::synthesize

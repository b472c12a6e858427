#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>

#include <vector>

namespace fresco::geometry
{

/// A few faces that are laid flat together, with vertices of their own.
struct FlatPatch
{
    std::vector<Triangle> triangles;
    std::vector<Vec3d> points;  ///< 3 per triangle: its corners on the surface.
    std::vector<Vec2d> places;  ///< One per vertex, in the plane; meters like the points.
    std::vector<bool> movable;  ///< One per vertex.
};

/// A face in the plane keeps at least this share of its area on the surface, or too few texels are left for it.
inline constexpr double smallest_area_share = 0.05;

/// How well a patch lies.
struct PatchFigures
{
    double least_area_share = 0;  ///< Smallest area in the plane over area on the surface; negative: a face is folded over.
    double square_stretch = 0;  ///< Sander's L² of the patch, squared and weighted by area; 1 = isometric. Of unfolded patches.
};

/// Moves the movable vertices so that no face is folded over and each keeps its shape as far as the fixed vertices allow: Newton
/// steps vertex by vertex on the regularized energy of Garanzha et al., "Foldover-free maps in 50 lines of code", SIGGRAPH 2021.
/// Begins from any places, folded or not. At most `sweeps` times over all vertices; the same result every time.
PatchFigures relax(FlatPatch& patch, int sweeps);

}  // namespace fresco::geometry

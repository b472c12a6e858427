#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstddef>
#include <vector>

namespace fresco::geometry
{

/// Changes that `repaired` made; 0 everywhere for a clean mesh.
struct RepairReport
{
    std::size_t duplicate_faces = 0;   ///< Removed: the same corners in the same direction as an earlier face.
    std::size_t degenerate_faces = 0;  ///< Removed: no area.
    std::size_t vertices_welded = 0;   ///< Ends of edges without length, merged into one.
    std::size_t complex_edges = 0;     ///< Edges of three or more faces, or of two that disagree about the outside.
    std::size_t vertices_added = 0;    ///< Copies made so that the surface around every vertex is one fan.
    std::size_t faces_detached = 0;    ///< Faces that only fit the surface with three vertices of their own.
    std::size_t vertices_unused = 0;   ///< Dropped: no face names them.
};

/// Repairs a surface to a manifold that a halfedge structure can hold: every edge has one or two faces of one orientation, the
/// faces around every vertex form one fan or one disk. No face with area is lost: where sheets touch, the faces that continue
/// each other best stay joined and vertices are copied for the others. Keeps the order of faces and of vertices (copies go to the
/// end) and the colors; drops texcoords and charts.
Mesh repaired(const Mesh& mesh, RepairReport& report, const Progress& progress);

/// Removes the vertices that no face names. Keeps the order of the others, and their colors.
void drop_unused_vertices(Mesh& mesh);

/// F: the faces that have the same corners in the same direction as an earlier face.
std::vector<bool> duplicate_faces(const Mesh& mesh);

}  // namespace fresco::geometry

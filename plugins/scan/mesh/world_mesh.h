#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>

#include <cstddef>
#include <string_view>
#include <vector>

/// \file Turns the mesh of a file into one of the world, for the stage: joins the vertices that the format split, and applies
/// unit, axes and transform.

namespace scan_mesh
{

/// Joins vertices of equal position and color, which formats with one texcoord per vertex split, so that adjacent faces share
/// them again. Faces that would repeat another face (the back of a wall without thickness) or have a vertex twice keep their own
/// vertices. Returns the number of removed vertices; texcoords stay.
std::size_t join_vertices(fresco::Mesh& mesh);

/// The rotation in `axes`: the file's axes that become x, y and z of the world, with optional signs. "x y z" changes nothing,
/// "x -z y" turns y up into z up. Throws Error for any other text, for an axis that occurs twice and for a reflection.
fresco::Mat3 axes_rotation(std::string_view axes);

/// Transforms positions: world = world_from_file(axes * (unit_m * p)). Throws Error if one leaves float's range.
void to_world(std::vector<fresco::Vec3d>& positions, double unit_m, const fresco::Mat3& axes,
              const fresco::RigidTransform& world_from_file);

/// Edges of the box around the vertices, along the axes; meters. \pre vertices
fresco::Vec3d extent_of(const fresco::Mesh& mesh);

}  // namespace scan_mesh

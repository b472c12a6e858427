#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>

#include <string_view>

namespace scan_mesh
{

/// The turn that `axes` names: which axis of the file becomes x, y and z of the world, each with a sign or without. "x y z"
/// changes nothing, "x -z y" sets upright what has y up. Throws Error if it is another text, names an axis twice or mirrors.
fresco::Mat3 axes_rotation(std::string_view axes);

/// Moves the vertices: world = world_from_file(axes * (unit_m * p)), in double precision. Throws Error if a vertex leaves float's
/// range.
void move_mesh(fresco::Mesh& mesh, double unit_m, const fresco::Mat3& axes, const fresco::RigidTransform& world_from_file);

/// Edges of the box around the vertices, along the axes; meters.
fresco::Vec3d extent_of(const fresco::Mesh& mesh);

}  // namespace scan_mesh

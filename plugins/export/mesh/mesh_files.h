#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <string>
#include <string_view>
#include <vector>

/// \file What export.mesh writes besides pictures and PLY (fresco/texturing/exports.h).

/// Wavefront OBJ text of a mesh: v (with the vertex colors where there is no material), vt (equal ones once, numbered by first
/// use), f in the mesh's order. Numbers read back exactly. `material_file` is empty for a mesh without a picture. `in_world`: of
/// a mesh with an offset the world_positions. The mesh must have passed check_mesh.
std::string obj_text(const fresco::Mesh& mesh, std::string_view material_file, std::string_view material, bool in_world = false);

/// The OBJ's material file: a white material that shows the picture unlit.
std::string mtl_text(std::string_view material, std::string_view picture_file);

/// Per vertex, the picture's color around it: the mean, in linear light, of the texels of the adjacent faces, each weighted by
/// its area on the surface and by its nearness to the vertex (its barycentric coordinate), sampled at every texel. Faces larger
/// than 256 texels are sampled 256 x 256 times. A vertex whose faces have no area takes the texel at its texcoord, one without
/// faces is gray. The mesh must have passed check_textured_mesh. Throws Canceled.
std::vector<fresco::Rgb8> vertex_colors(const fresco::TexturedMesh& textured, const fresco::Progress& progress);

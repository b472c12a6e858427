#pragma once

#include <fresco/mesh.h>

#include <string>
#include <string_view>

/// Wavefront OBJ text of a mesh: v (with the vertex colors where there is no material), vt (equal ones once, numbered by first
/// use), f in the mesh's order. Numbers read back exactly. `material_file` is empty for a mesh without a picture. The mesh must
/// have passed check_mesh.
std::string obj_text(const fresco::Mesh& mesh, std::string_view material_file, std::string_view material);

/// Its material file: a white material that shows the picture unlit.
std::string mtl_text(std::string_view material, std::string_view picture_file);

#pragma once

#include <fresco/texture.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

/// \file What every export checks and says.

namespace fresco::texturing
{

/// Throws Error naming `source` unless the mesh is one that can be exported: as check_mesh, with texcoords, and a square picture.
void check_textured_mesh(const TexturedMesh& textured, std::string_view source);

/// Compares a mesh that was read again with the one that was to be written: positions, vertex colors, triangles and texcoords,
/// all bit by bit, but for faces that name a vertex twice, which readers drop. Throws Error naming the first difference.
void check_written_mesh(const Mesh& found, const Mesh& meant);

/// "1 234 567"
std::string grouped(std::uint64_t number);
/// "12.3 MB", "4.0 kB", "17 bytes"; of 1000, as file managers count.
std::string file_size(std::uint64_t bytes);

/// "room.glb: 12.3 MB, 499 999 triangles, valid": for what was read again and found to be what was meant. `what` may be empty.
std::string valid_line(std::string_view name, std::uint64_t bytes, std::string_view what);

}  // namespace fresco::texturing

#pragma once

#include <fresco/texturing/welded_mesh.h>

#include <string>
#include <string_view>
#include <vector>

/// A file of a package; `data` points into the package.
struct UsdzEntry
{
    std::string name;
    std::string_view data;
};

/// Takes a package apart and holds it against the usdz specification, byte by byte: files stored as they are, data at multiples
/// of 64 bytes, headers and directory in agreement, checksums right, nothing between or behind. Throws Error naming `source`, the
/// file in the package, and what was expected.
std::vector<UsdzEntry> read_usdz(std::string_view package, std::string_view source);

/// Compares the numbers of a layer with the mesh that was to be written: triangles, positions and texcoords, bit by bit. Throws
/// Error naming the first difference.
void check_usda(std::string_view layer, const fresco::texturing::WeldedMesh& mesh);

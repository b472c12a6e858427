#pragma once

#include <fresco/texturing/welded_mesh.h>

#include <string>
#include <string_view>

/// \file EXT_meshopt_compression, by meshoptimizer, as a pass over a GLB: tinygltf writes and reads no extension of views.

/// Reorders triangles and vertices so that neighbors follow each other: the streams become smaller. The surface is the same.
void order_for_compression(fresco::texturing::WeldedMesh& mesh);

/// A GLB of make_glb with its vertices and indices compressed. Corners of a triangle may be turned: (a, b, c) to (b, c, a).
std::string compressed_glb(std::string_view glb);

/// The reverse, checked; empty if nothing in the GLB is compressed. Throws Error naming the view: one outside of the file, a
/// stream that does not hold exactly so many rows or indices, an extension that is not declared as required.
std::string restored_glb(std::string_view glb);

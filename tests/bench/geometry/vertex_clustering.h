#pragma once

#include <fresco/mesh.h>

#include <cstddef>

namespace bench
{

/// The simplest decimation, to compare others with: vertices in one cell of a grid become their mean (Rossignac and Borrel,
/// "Multi-resolution 3D approximations for rendering complex scenes", 1993). Searches the cell size that gives at most
/// `max_faces` triangles. Colors are dropped.
fresco::Mesh clustered(const fresco::Mesh& mesh, std::size_t max_faces);

}  // namespace bench

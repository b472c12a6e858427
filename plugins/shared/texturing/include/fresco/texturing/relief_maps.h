#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/relief.h>

namespace fresco::texturing
{

/// Axes of a normal map's components.
enum class NormalFrame
{
    tangent,  ///< Tangent, bitangent and normal of each vertex (add_tangents), interpolated over faces: as glTF and USD take it.
    world     ///< The mesh's x, y and z.
};

/// The pictures of a relief that a material takes. The gutter is filled.
struct ReliefMaps
{
    Raster8 normals;    ///< S x S x 3: 127.5 (n + 1) of each component n.
    Raster8 roughness;  ///< S x S
};

/// Maps of at most `max_px` texels a side, 0: as many as the relief has; texels average those of their own chart. The mesh must
/// have passed check_mesh and be the one of the relief. Equal for any number of threads. Throws Canceled.
ReliefMaps tangent_maps(const Relief& relief, const Mesh& mesh, int max_px, const Progress& progress);

/// Maps in NormalFrame::world, for which no mesh is needed; texels average all that lie below them.
ReliefMaps world_maps(const Relief& relief, int max_px, const Progress& progress);

}  // namespace fresco::texturing

#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fresco::texturing
{

/// Gives covered texels that were not seen the colors of the seen surface around them: the smooth (harmonic) field over the
/// surface that meets the seen colors at their border. It runs along the surface, across the atlas's seams and never through the
/// gutter; a part of the surface that joins no seen one starts from the colors that are nearest in space. Solved from coarse to
/// fine on the texels' own grid (cascadic multigrid, Bornemann and Deuflhard 1996), in a fixed order on one thread. `rgb`: S x S
/// x 3. `seen`: S x S. Returns the number of texels filled. Throws Error if no covered texel was seen, Canceled.
std::size_t fill_unseen(const Mesh& mesh, const Charts& charts, const TexelFaces& faces, const std::vector<std::uint8_t>& seen,
                        RasterF& rgb, const Progress& progress);

}  // namespace fresco::texturing

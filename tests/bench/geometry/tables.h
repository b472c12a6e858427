#pragma once

#include "inputs.h"
#include "table.h"

#include <vector>

namespace bench
{

struct GeometrySettings
{
    std::vector<int> heights_px{256, 432, 608, 784};
    double keep = 0.1;               ///< Share of the faces that decimation leaves.
    std::vector<std::size_t> faces;  ///< Decimates to these numbers of faces in place of `keep`, where there are more.
    int repeats = 1;                 ///< Of a decimation; the fastest counts.
    int size_px = 2048;              ///< Of the texture that atlases are made for.
    std::size_t samples = 50'000;    ///< Points per surface for distances.
    int threads = 1;
};

/// Each implementation of decimation on each input.
Table decimation_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings);

/// Each atlas on each input, decimated as above; atlas.project on the whole input too.
Table atlas_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings);

/// Uv maps at the heights by each implementation, on one thread and on all.
Table uv_map_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings);

/// How far the implementations of uv maps agree with one another.
Table uv_map_agreement_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings);

/// Tiny uv maps against the way without a search structure: time and equality.
Table uv_map_twin_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings);

/// Uv maps of an atlas on each input, decimated as above, held as bytes in several ways.
Table packed_uv_map_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings);

/// Two textures mixed on an atlas of each input, decimated as above: texture.mix against every texel by itself.
Table mix_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings);

/// The implementation that a run uses: what the atlas is laid on.
fresco::Mesh simplified(const fresco::Mesh& mesh, const GeometrySettings& settings);

}  // namespace bench

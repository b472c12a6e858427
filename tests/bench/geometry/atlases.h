#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <functional>
#include <vector>

namespace bench
{

/// An atlas for a texture of size_px², with a gutter of 4 texels.
struct AtlasMaker
{
    const char* name;
    std::function<fresco::Mesh(const fresco::Mesh&, int size_px, fresco::Progress&)> run;
    /// Of another program: what its last run took, without carrying the mesh over.
    std::function<double()> own_seconds = {};
};

/// With the stages' default options. The first is what the others' times are compared with.
const std::vector<AtlasMaker>& atlas_makers();

}  // namespace bench

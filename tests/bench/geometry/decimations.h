#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace bench
{

/// A way to simplify a manifold mesh to about so many faces, with the threads of the progress.
struct Decimation
{
    std::string name;
    std::function<fresco::Mesh(const fresco::Mesh&, std::size_t, fresco::Progress&)> run;
    /// Of another program: what its last run took, without carrying the mesh over.
    std::function<double()> own_seconds = {};
};

/// mesh.decimate first, then what the machine has.
const std::vector<Decimation>& decimations();

/// By CGAL; empty where it was not found.
std::vector<Decimation> cgal_decimations();
/// By meshoptimizer; empty where it was not found.
std::vector<Decimation> meshoptimizer_decimations();

}  // namespace bench

#include "decimations.h"

#include <meshoptimizer.h>

#include <limits>

namespace bench
{
namespace
{

fresco::Mesh simplified(const fresco::Mesh& mesh, std::size_t target, fresco::Progress&)
{
    std::vector<unsigned int> indices;
    indices.reserve(3 * mesh.triangles.size());
    for (const auto& t : mesh.triangles)
        indices.insert(indices.end(), t.begin(), t.end());
    std::vector<unsigned int> left(indices.size());
    // A number for the error's limit that is never reached: only the count ends it.
    const std::size_t count =
        meshopt_simplify(left.data(), indices.data(), indices.size(), &mesh.positions[0].x, mesh.positions.size(),
                         sizeof(fresco::Vec3f), 3 * target, std::numeric_limits<float>::max(), 0U, nullptr);
    fresco::Mesh result;
    result.positions = mesh.positions;
    for (std::size_t i = 0; i < count; i += 3)
        result.triangles.push_back({left[i], left[i + 1], left[i + 2]});
    return result;
}

}  // namespace

std::vector<Decimation> meshoptimizer_decimations()
{
    return {
        {"meshoptimizer " + std::to_string(MESHOPTIMIZER_VERSION / 1000) + "." + std::to_string(MESHOPTIMIZER_VERSION / 10 % 100),
         simplified}};
}

}  // namespace bench

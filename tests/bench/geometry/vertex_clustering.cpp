#include "vertex_clustering.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

namespace bench
{
namespace
{

constexpr int search_steps = 12;

/// Three numbers of 21 bits, which reach beyond any room.
std::uint64_t cell_of(fresco::Vec3f p, double cell)
{
    const auto number = [cell](float x)
    { return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(static_cast<double>(x) / cell)) + (1 << 20)); };
    return number(p.x) << 42U | number(p.y) << 21U | number(p.z);
}

struct Clusters
{
    std::vector<std::uint32_t> of_vertex;
    std::vector<fresco::Vec3d> sums;
    std::vector<double> counts;
};

Clusters clusters(const fresco::Mesh& mesh, double cell)
{
    Clusters result;
    std::unordered_map<std::uint64_t, std::uint32_t> numbers;
    for (const auto& p : mesh.positions)
    {
        const auto number = numbers.emplace(cell_of(p, cell), static_cast<std::uint32_t>(numbers.size())).first->second;
        result.sums.resize(numbers.size());
        result.counts.resize(numbers.size());
        result.of_vertex.push_back(number);
        result.sums[number] += fresco::vec_cast<double>(p);
        result.counts[number] += 1;
    }
    return result;
}

/// The same cycle, smallest corner first.
fresco::Triangle rotated(fresco::Triangle t)
{
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

fresco::Mesh clustered_by(const fresco::Mesh& mesh, double cell)
{
    const auto found = clusters(mesh, cell);
    fresco::Mesh result;
    for (std::size_t i = 0; i < found.sums.size(); ++i)
        result.positions.push_back(fresco::vec_cast<float>(found.sums[i] * (1 / found.counts[i])));
    std::set<fresco::Triangle> known;
    for (const auto& t : mesh.triangles)
    {
        const fresco::Triangle face{found.of_vertex[t[0]], found.of_vertex[t[1]], found.of_vertex[t[2]]};
        if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0] && known.insert(rotated(face)).second)
            result.triangles.push_back(face);
    }
    return result;
}

}  // namespace

fresco::Mesh clustered(const fresco::Mesh& mesh, std::size_t max_faces)
{
    double fine = 1e-3;
    double coarse = 1;
    fresco::Mesh best = clustered_by(mesh, coarse);
    for (int i = 0; i < search_steps; ++i)
    {
        const double cell = std::sqrt(fine * coarse);
        auto candidate = clustered_by(mesh, cell);
        if (candidate.triangles.size() > max_faces)
        {
            fine = cell;
            continue;
        }
        coarse = cell;
        best = std::move(candidate);
    }
    return best;
}

}  // namespace bench

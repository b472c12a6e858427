#include "decimate.h"

#include "edge_queue.h"
#include "pieces.h"

#include <fresco/numerics/radix_sort.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

using fresco::Mesh;
using fresco::Vec3d;
using fresco::Vec3f;

namespace
{

/// Of the faces that are left to remove, a step may take this share before prices are compared again.
constexpr double step_share = 0.6;
/// Edges that become unfit or dearer for each collapse, about.
constexpr double edges_per_collapse = 2.5;
/// The first cut leaves this share of the removals to the second, which reaches what rested.
constexpr double second_share = 0.12;
/// Price classes: the leading bits of a float.
constexpr int class_shift = 18;
constexpr double most_eager = 1e9;

Surface surface_of(const Mesh& mesh)
{
    Surface surface{mesh.positions, std::vector<VertexLoad>(mesh.positions.size()), mesh.triangles};
    for (const auto& t : mesh.triangles)
    {
        const Vec3f a = mesh.positions[t[0]];
        const Vec3f normal = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
        const float area = length(normal) / 6;
        for (const std::uint32_t v : t)
        {
            surface.loads[v].normal += normal;
            surface.loads[v].area += area;
        }
    }
    if (!mesh.colors.empty())
        for (std::size_t v = 0; v < mesh.colors.size(); ++v)
            surface.loads[v].color = {static_cast<float>(mesh.colors[v][0]), static_cast<float>(mesh.colors[v][1]),
                                      static_cast<float>(mesh.colors[v][2])};
    return surface;
}

Mesh mesh_of(const Surface& surface, bool colored)
{
    Mesh mesh;
    std::vector<std::uint32_t> index(surface.positions.size(), Piece::none);
    for (const auto& t : surface.triangles)
        for (const std::uint32_t v : t)
            index[v] = 0;
    const auto byte = [](float value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 255.0F))); };
    for (std::size_t v = 0; v < index.size(); ++v)
    {
        if (index[v] == Piece::none)
            continue;
        index[v] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(surface.positions[v]);
        if (const Vec3f color = surface.loads[v].color; colored)
            mesh.colors.push_back({byte(color.x), byte(color.y), byte(color.z)});
    }
    mesh.triangles.reserve(surface.triangles.size());
    for (const auto& t : surface.triangles)
        mesh.triangles.push_back({index[t[0]], index[t[1]], index[t[2]]});
    return mesh;
}

/// How many waiting edges there are of each price class, of one piece.
using Prices = std::vector<std::uint32_t>;

Prices prices_of(const EdgeQueue& queue)
{
    Prices prices((0xffffffffU >> class_shift) + 1, 0);
    queue.each_cost([&](float cost) { ++prices[fresco::numerics::ordered_key(cost) >> class_shift]; });
    return prices;
}

/// Collapses in all pieces until `target` faces are left, or nothing more can be collapsed.
class Steps
{
  public:
    Steps(std::vector<CutPiece>& pieces, fresco::Progress& progress)
        : pieces_(pieces), queues_(pieces.size()), progress_(progress)
    {
        each([&](std::size_t i) { queues_[i] = std::make_unique<EdgeQueue>(*pieces_[i].piece); });
    }

    std::size_t faces() const
    {
        std::size_t sum = 0;
        for (const CutPiece& piece : pieces_)
            sum += piece.piece->faces();
        return sum;
    }

    /// `total`: the number that progress counts toward.
    void run(std::size_t target, std::size_t from, std::size_t end)
    {
        // Where all of the cheapest edges turn out unfit, the next step looks at more.
        double eagerness = 1;
        while (faces() > target)
        {
            progress_.progress(static_cast<double>(from - faces()), static_cast<double>(from - end), "faces removed");
            const std::size_t removed = step(faces() - target, eagerness);
            if (removed == 0 && eagerness > most_eager)
                return;
            eagerness = removed == 0 ? 4 * eagerness : 1;
        }
    }

  private:
    void each(const std::function<void(std::size_t)>& act)
    {
        fresco::parallel_for(pieces_.size(), 1, progress_.threads(),
                             [&](std::size_t i, std::size_t)
                             {
                                 progress_.check_canceled();
                                 act(i);
                             });
    }

    /// Removes at most `surplus` faces (one more where the last collapse removes two).
    std::size_t step(std::size_t surplus, double eagerness)
    {
        std::vector<Prices> prices(pieces_.size());
        each([&](std::size_t i) { prices[i] = prices_of(*queues_[i]); });
        const bool last = surplus < 4 * pieces_.size() + 64;
        const double wanted = static_cast<double>(surplus) / 2 * (last ? 4 : step_share) * edges_per_collapse * eagerness;
        // The price at which so many edges wait.
        std::size_t price = 0;
        double waiting = 0;
        for (; price < prices[0].size() && waiting < wanted; ++price)
            for (const Prices& of : prices)
                waiting += of[price];
        if (waiting == 0)
            return 0;
        // Each piece may take its share of the surplus.
        std::vector<std::size_t> caps(pieces_.size());
        double shared = 0;
        std::size_t given = 0;
        for (std::size_t i = 0; i < caps.size(); ++i)
        {
            for (std::size_t p = 0; p < price; ++p)
                shared += prices[i][p];
            // Even, as most collapses remove two faces.
            const auto up_to =
                2 * static_cast<std::size_t>(std::ceil(shared / waiting * static_cast<double>(surplus) / 2 - 1e-9));
            caps[i] = up_to - given;
            given = up_to;
        }
        const auto key = static_cast<std::uint32_t>(price) << class_shift;
        const float most =
            price >= prices[0].size() ? std::numeric_limits<float>::max() : std::bit_cast<float>((key - 1) & 0x7fffffffU);
        std::vector<std::size_t> removed(pieces_.size());
        each([&](std::size_t i) { removed[i] = queues_[i]->run(most, caps[i]); });
        std::size_t sum = 0;
        for (const std::size_t one : removed)
            sum += one;
        return sum;
    }

    std::vector<CutPiece>& pieces_;
    std::vector<std::unique_ptr<EdgeQueue>> queues_;
    fresco::Progress& progress_;
};

}  // namespace

Mesh decimated(const Mesh& mesh, const DecimateOptions& options, fresco::Progress& progress)
{
    const std::size_t before = mesh.triangles.size();
    Surface surface = surface_of(mesh);
    for (int turn = 0; surface.triangles.size() > options.max_faces; ++turn)
    {
        const std::size_t now = surface.triangles.size();
        auto pieces = cut(surface, regions_of(surface, options.piece_faces, turn, progress), progress);
        const std::size_t surplus = now - options.max_faces;
        // What rests in this turn is done in the next.
        const auto left =
            turn == 0 && pieces.size() > 1 ? static_cast<std::size_t>(second_share * static_cast<double>(surplus)) : 0;
        Steps steps(pieces, progress);
        steps.run(options.max_faces + left, before, options.max_faces);
        put_back(pieces, surface, progress);
        if (surface.triangles.size() == now)
            break;
    }
    return mesh_of(surface, !mesh.colors.empty());
}

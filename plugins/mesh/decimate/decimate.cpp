#include "decimate.h"

#include "collapse.h"

#include <fresco/geometry/repair.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

using fresco::Mesh;
using fresco::Triangle;
using fresco::Vec3d;
using fresco::Vec3f;

namespace
{

/// The surface between two cuts into pieces.
struct Surface
{
    std::vector<Vec3f> positions;
    std::vector<VertexLoad> loads;
    std::vector<Triangle> triangles;
};

/// Faces sorted by position: the ranges of `order` are compact regions of at most `most` faces, split at fractions of the number
/// of faces that depend on `turn`, so that two turns cut along different lines.
struct Regions
{
    std::vector<std::uint32_t> order;
    std::vector<std::uint32_t> begins;  ///< One more than there are regions.
};

/// A piece with its vertices in the surface.
struct CutPiece
{
    std::unique_ptr<Piece> piece;
    std::vector<std::uint32_t> vertices;  ///< By local vertex: the surface's.
};

/// Shares at which regions are split, never twice in a row at the same one.
constexpr std::array<double, 4> split_shares{0.5, 0.38, 0.62, 0.45};

struct Range
{
    std::uint32_t begin, end;
};

float along(Vec3f p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/// Sorts the faces of a range to both sides of a plane across its longest extent; returns where they part.
std::uint32_t split(const std::vector<Vec3f>& centers, std::vector<std::uint32_t>& order, Range range, double share)
{
    fresco::numerics::Bounds<float> box;
    for (std::uint32_t i = range.begin; i < range.end; ++i)
        box.add(centers[order[i]]);
    const Vec3f extent = box.high - box.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto parting = range.begin + static_cast<std::uint32_t>(share * (range.end - range.begin));
    std::nth_element(order.begin() + range.begin, order.begin() + parting, order.begin() + range.end,
                     [&](std::uint32_t a, std::uint32_t b)
                     { return std::pair(along(centers[a], axis), a) < std::pair(along(centers[b], axis), b); });
    return parting;
}

Regions regions_of(const Surface& surface, std::size_t most, int turn, const fresco::Progress& progress)
{
    const auto faces = static_cast<std::uint32_t>(surface.triangles.size());
    std::vector<Vec3f> centers(faces);
    fresco::parallel_items(faces, 65536, progress,
                           [&](std::uint32_t f)
                           {
                               const auto& [a, b, c] = surface.triangles[f];
                               centers[f] = surface.positions[a] + surface.positions[b] + surface.positions[c];
                           });
    Regions regions;
    regions.order.resize(faces);
    std::iota(regions.order.begin(), regions.order.end(), 0U);
    std::vector<Range> ranges{{0, faces}};
    for (std::size_t level = 0;; ++level)
    {
        progress.check_canceled();
        std::vector<std::vector<Range>> parts(ranges.size());
        const double share = split_shares[(level + static_cast<std::size_t>(turn)) % split_shares.size()];
        fresco::parallel_items(ranges.size(), 1, progress,
                               [&](std::size_t i)
                               {
                                   const Range range = ranges[i];
                                   if (range.end - range.begin <= most)
                                       parts[i] = {range};
                                   else
                                   {
                                       const std::uint32_t parting = split(centers, regions.order, range, share);
                                       parts[i] = {{range.begin, parting}, {parting, range.end}};
                                   }
                               });
        const std::size_t before = ranges.size();
        ranges.clear();
        for (const auto& part : parts)
            ranges.insert(ranges.end(), part.begin(), part.end());
        if (ranges.size() == before)
            break;
    }
    // Within a region faces stay in the order of the mesh: neighbors on the surface are mostly neighbors in memory.
    std::vector<std::uint32_t> region(faces);
    for (std::uint32_t r = 0; r < ranges.size(); ++r)
    {
        regions.begins.push_back(ranges[r].begin);
        for (std::uint32_t i = ranges[r].begin; i < ranges[r].end; ++i)
            region[regions.order[i]] = r;
    }
    auto next = regions.begins;
    for (std::uint32_t f = 0; f < faces; ++f)
        regions.order[next[region[f]]++] = f;
    regions.begins.push_back(faces);
    return regions;
}

std::vector<CutPiece> cut(const Surface& surface, const Regions& regions, const fresco::Progress& progress)
{
    const std::size_t count = regions.begins.size() - 1;
    // The piece that has a vertex to itself; `shared` where several have it.
    constexpr std::uint32_t shared = Piece::none - 1;
    std::vector<std::uint32_t> owner(surface.positions.size(), Piece::none);
    for (std::uint32_t r = 0; r < count; ++r)
        for (std::uint32_t i = regions.begins[r]; i < regions.begins[r + 1]; ++i)
            for (const std::uint32_t v : surface.triangles[regions.order[i]])
                if (owner[v] != r)
                    owner[v] = owner[v] == Piece::none ? r : shared;
    // Local numbers of vertices with one owner; only the owner writes there.
    std::vector<std::uint32_t> local(surface.positions.size(), Piece::none);
    std::vector<CutPiece> pieces(count);
    fresco::parallel_items(count, 1, progress,
                           [&](std::size_t r)
                           {
                               CutPiece& made = pieces[r];
                               const std::span<const std::uint32_t> order(regions.order.data() + regions.begins[r],
                                                                          regions.begins[r + 1] - regions.begins[r]);
                               std::vector<std::uint32_t> rests;
                               for (const std::uint32_t f : order)
                                   for (const std::uint32_t v : surface.triangles[f])
                                       if (owner[v] == shared)
                                           rests.push_back(v);
                               std::sort(rests.begin(), rests.end());
                               rests.erase(std::unique(rests.begin(), rests.end()), rests.end());
                               made.vertices = rests;
                               made.vertices.reserve(rests.size() + order.size() / 2 + 16);
                               std::vector<Triangle> faces;
                               faces.reserve(order.size());
                               for (const std::uint32_t f : order)
                               {
                                   Triangle& face = faces.emplace_back();
                                   for (std::size_t k = 0; k < 3; ++k)
                                   {
                                       const std::uint32_t v = surface.triangles[f][k];
                                       if (owner[v] == shared)
                                       {
                                           face[k] = static_cast<std::uint32_t>(std::lower_bound(rests.begin(), rests.end(), v) -
                                                                                rests.begin());
                                           continue;
                                       }
                                       if (local[v] == Piece::none)
                                       {
                                           local[v] = static_cast<std::uint32_t>(made.vertices.size());
                                           made.vertices.push_back(v);
                                       }
                                       face[k] = local[v];
                                   }
                               }
                               std::vector<Vec3f> positions;
                               std::vector<VertexLoad> loads;
                               positions.reserve(made.vertices.size());
                               loads.reserve(made.vertices.size());
                               for (const std::uint32_t v : made.vertices)
                               {
                                   positions.push_back(surface.positions[v]);
                                   loads.push_back(surface.loads[v]);
                               }
                               made.piece = std::make_unique<Piece>(std::move(positions), std::move(loads), rests.size(), faces);
                           });
    return pieces;
}

/// Writes the pieces back: positions and loads of their vertices, and their remaining faces, in the order of the pieces.
void put_back(const std::vector<CutPiece>& pieces, Surface& surface, const fresco::Progress& progress)
{
    std::vector<std::size_t> begin{0};
    for (const CutPiece& cut_piece : pieces)
        begin.push_back(begin.back() + cut_piece.piece->faces());
    surface.triangles.resize(begin.back());
    fresco::parallel_items(
        pieces.size(), 1, progress,
        [&](std::size_t r)
        {
            const Piece& piece = *pieces[r].piece;
            const auto& vertices = pieces[r].vertices;
            std::size_t at = begin[r];
            for (std::uint32_t h = 0; h < piece.halves(); h += 4)
                if (piece.alive(h))
                    surface.triangles[at++] = {vertices[piece.from(h)], vertices[piece.from(h + 1)], vertices[piece.from(h + 2)]};
            for (std::uint32_t v = 0; v < piece.vertices(); ++v)
                if (!piece.frozen(v))
                {
                    surface.positions[vertices[v]] = piece.position(v);
                    surface.loads[vertices[v]] = piece.load(v);
                }
        });
}

/// Share of the faces still to remove that a step may remove before costs are compared again.
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

Mesh mesh_of(Surface surface, bool colored)
{
    Mesh mesh;
    mesh.positions = std::move(surface.positions);
    mesh.triangles = std::move(surface.triangles);
    const auto byte = [](float value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 255.0F))); };
    if (colored)
        for (const VertexLoad& load : surface.loads)
            mesh.colors.push_back({byte(load.color.x), byte(load.color.y), byte(load.color.z)});
    fresco::geometry::drop_unused_vertices(mesh);
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
        // If all of the cheapest edges are unfit, the next step considers more.
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
        fresco::parallel_items(pieces_.size(), 1, progress_, [&](std::size_t i) { act(i); });
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
        return std::accumulate(removed.begin(), removed.end(), std::size_t{0});
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
        // The next turn works on the rest.
        const auto left =
            turn == 0 && pieces.size() > 1 ? static_cast<std::size_t>(second_share * static_cast<double>(surplus)) : 0;
        Steps steps(pieces, progress);
        steps.run(options.max_faces + left, before, options.max_faces);
        put_back(pieces, surface, progress);
        if (surface.triangles.size() == now)
            break;
    }
    return mesh_of(std::move(surface), !mesh.colors.empty());
}

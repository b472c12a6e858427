#include "pieces.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <limits>
#include <numeric>

using fresco::Triangle;
using fresco::Vec3f;

namespace
{

/// Where a region is split: never twice in a row at the same share.
constexpr std::array<double, 4> split_shares{0.5, 0.38, 0.62, 0.45};

struct Range
{
    std::uint32_t begin, end;
};

Vec3f center(const Surface& surface, std::uint32_t face)
{
    const Triangle& t = surface.triangles[face];
    return surface.positions[t[0]] + surface.positions[t[1]] + surface.positions[t[2]];
}

float along(Vec3f p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/// Sorts the faces of a range to both sides of a plane across its longest extent; returns where they part.
std::uint32_t split(const std::vector<Vec3f>& centers, std::vector<std::uint32_t>& order, Range range, double share)
{
    constexpr float far = std::numeric_limits<float>::infinity();
    Vec3f low{far, far, far};
    Vec3f high{-far, -far, -far};
    for (std::uint32_t i = range.begin; i < range.end; ++i)
    {
        const Vec3f p = centers[order[i]];
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const Vec3f extent = high - low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto parting = range.begin + static_cast<std::uint32_t>(share * (range.end - range.begin));
    std::nth_element(order.begin() + range.begin, order.begin() + parting, order.begin() + range.end,
                     [&](std::uint32_t a, std::uint32_t b)
                     {
                         const float pa = along(centers[a], axis);
                         const float pb = along(centers[b], axis);
                         return pa != pb ? pa < pb : a < b;
                     });
    return parting;
}

}  // namespace

Regions regions_of(const Surface& surface, std::size_t most, int turn, const fresco::Progress& progress)
{
    const auto faces = static_cast<std::uint32_t>(surface.triangles.size());
    std::vector<Vec3f> centers(faces);
    fresco::parallel_for(faces, 65536, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             for (std::size_t f = begin; f < end; ++f)
                                 centers[f] = center(surface, static_cast<std::uint32_t>(f));
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
        fresco::parallel_for(ranges.size(), 1, progress.threads(),
                             [&](std::size_t i, std::size_t)
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
    // Of vertices with one owner; only the owner writes there.
    std::vector<std::uint32_t> local(surface.positions.size(), Piece::none);
    std::vector<CutPiece> pieces(count);
    fresco::parallel_for(count, 1, progress.threads(),
                         [&](std::size_t r, std::size_t)
                         {
                             progress.check_canceled();
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

void put_back(const std::vector<CutPiece>& pieces, Surface& surface, const fresco::Progress& progress)
{
    std::vector<std::size_t> begin{0};
    for (const CutPiece& cut_piece : pieces)
        begin.push_back(begin.back() + cut_piece.piece->faces());
    surface.triangles.resize(begin.back());
    fresco::parallel_for(
        pieces.size(), 1, progress.threads(),
        [&](std::size_t r, std::size_t)
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

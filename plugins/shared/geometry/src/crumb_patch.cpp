#include "crumb_patch.h"

#include <fresco/numerics/disjoint_sets.h>

namespace fresco::geometry
{
namespace
{

/// Corners of one vertex that differ by less (meters) are in one place.
constexpr double same_place_m = 1e-9;
constexpr int contractions = 20;

void unroll(CrumbPatch& patch)
{
    auto& shape = patch.shape;
    auto known = patch.on_chart;
    for (bool more = true; more;)
    {
        more = false;
        for (std::size_t f = 0; f < shape.triangles.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto from = shape.triangles[f][k];
                const auto to = shape.triangles[f][(k + 1) % 3];
                const auto apex = shape.triangles[f][(k + 2) % 3];
                if (!known[from] || !known[to] || known[apex])
                    continue;
                const auto base = shape.points[3 * f + k];
                const auto edge = shape.points[3 * f + (k + 1) % 3] - base;
                const auto side = shape.points[3 * f + (k + 2) % 3] - base;
                const auto flat_edge = shape.places[to] - shape.places[from];
                if (!(dot(edge, edge) > 0) || !(dot(flat_edge, flat_edge) > 0))
                    continue;
                const double along = dot(side, edge) / dot(edge, edge);
                const double height = length(cross(edge, side)) / length(edge);
                const Vec2d left = normalized(Vec2d{-flat_edge.y, flat_edge.x});
                shape.places[apex] = shape.places[from] + flat_edge * along + left * height;
                known[apex] = true;
                more = true;
            }
    }
}

}  // namespace

bool PatchMaker::together(std::uint32_t f, std::uint32_t g, std::uint32_t vertex) const
{
    return length(charts_.place(f, vertex) - charts_.place(g, vertex)) <= same_place_m;
}

std::optional<CrumbPatch> PatchMaker::make(std::uint32_t crumb, std::uint32_t chart, int steps)
{
    FaceList faces;
    collect(crumb, chart, steps, faces);
    auto patch = assemble(faces, chart);
    for (const auto f : faces)
        place_[f] = none;
    if (!patch)
        return std::nullopt;
    patch->faces = std::move(faces);
    unroll(*patch);
    return patch;
}

void PatchMaker::collect(std::uint32_t crumb, std::uint32_t chart, int steps, FaceList& patch)
{
    const auto& surface = charts_.surface();
    const auto& owner = charts_.flat().chart_of_face;
    patch = charts_.faces(crumb);
    for (std::uint32_t i = 0; i < patch.size(); ++i)
        place_[patch[i]] = i;
    std::size_t begin = 0;
    for (int step = 0; step < steps; ++step)
    {
        const auto end = patch.size();
        for (; begin < end; ++begin)
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto f = patch[begin];
                const auto g = surface.neighbors[f][k];
                if (g == none || owner[g] != chart || place_[g] != none)
                    continue;
                const auto& t = surface.mesh.triangles[f];
                if (owner[f] == chart && !(together(f, g, t[k]) && together(f, g, t[(k + 1) % 3])))
                    continue;
                place_[g] = static_cast<std::uint32_t>(patch.size());
                patch.push_back(g);
            }
    }
}

std::optional<CrumbPatch> PatchMaker::assemble(const FaceList& patch, std::uint32_t chart) const
{
    const auto& surface = charts_.surface();
    const auto& owner = charts_.flat().chart_of_face;
    const auto in_patch = [&](std::uint32_t face, std::uint32_t vertex)
    { return static_cast<std::uint32_t>(3 * std::size_t{place_[face]} + charts_.corner(face, vertex) - 3 * std::size_t{face}); };

    numerics::DisjointSets corners(3 * patch.size());
    std::vector<bool> held(3 * patch.size(), false);
    for (const auto f : patch)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto g = surface.neighbors[f][k];
            if (g == none)
                continue;
            const bool of_chart = owner[f] == chart && owner[g] == chart;
            const std::array ends{surface.mesh.triangles[f][k], surface.mesh.triangles[f][(k + 1) % 3]};
            if (place_[g] != none)
            {
                if (!of_chart || (together(f, g, ends[0]) && together(f, g, ends[1])))
                    for (const auto v : ends)
                        corners.join(in_patch(f, v), in_patch(g, v));
            }
            else if (of_chart)
                for (const auto v : ends)
                    held[in_patch(f, v)] = held[in_patch(f, v)] || together(f, g, v);
        }

    CrumbPatch out;
    auto& shape = out.shape;
    std::vector<std::uint32_t> vertex_of(3 * patch.size(), none);
    for (std::uint32_t i = 0; i < patch.size(); ++i)
    {
        Triangle triangle;
        for (std::uint32_t k = 0; k < 3; ++k)
        {
            auto& v = vertex_of[corners.find(3 * i + k)];
            if (v == none)
            {
                v = static_cast<std::uint32_t>(shape.places.size());
                shape.places.emplace_back();
                shape.movable.push_back(true);
                out.on_chart.push_back(false);
            }
            triangle[k] = v;
            const auto on_surface = surface.mesh.triangles[patch[i]][k];
            shape.points.push_back(vec_cast<double>(surface.mesh.positions[on_surface]));
            if (owner[patch[i]] != chart)
                continue;
            const auto place = charts_.place(patch[i], on_surface);
            if (held[3 * i + k] && !shape.movable[v] && length(place - shape.places[v]) > same_place_m)
                return std::nullopt;
            if (held[3 * i + k] || !out.on_chart[v])
                shape.places[v] = place;
            shape.movable[v] = shape.movable[v] && !held[3 * i + k];
            out.on_chart[v] = true;
        }
        shape.triangles.push_back(triangle);
    }
    return out;
}

void contract(CrumbPatch& patch)
{
    auto& places = patch.shape.places;
    std::vector<Vec2d> sum(places.size());
    std::vector<double> count(places.size());
    for (int i = 0; i < contractions; ++i)
    {
        std::fill(sum.begin(), sum.end(), Vec2d{});
        std::fill(count.begin(), count.end(), 0.0);
        for (const auto& t : patch.shape.triangles)
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t m = 1; m < 3; ++m)
                {
                    sum[t[k]] = sum[t[k]] + places[t[(k + m) % 3]];
                    ++count[t[k]];
                }
        for (std::size_t v = 0; v < places.size(); ++v)
            if (!patch.on_chart[v])
                places[v] = sum[v] * (1 / count[v]);
    }
}

}  // namespace fresco::geometry

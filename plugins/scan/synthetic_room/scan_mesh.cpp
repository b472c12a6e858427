#include "scan_mesh.h"

#include "noise.h"

#include <fresco/error.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace room
{
namespace
{

constexpr int padding = 2;
constexpr int block_cells = 8;
constexpr std::uint32_t no_vertex = 0xffffffffU;

struct GridPoint
{
    int x, y, z;
};

/// Distances of grid nodes to the scene, with a list of the near solids for each block of cells.
class DistanceGrid
{
  public:
    DistanceGrid(const Scene& scene, float edge) : scene_(scene), edge_(edge)
    {
        const auto nodes = [&](float size) { return static_cast<int>(std::ceil(size / edge)) + 2 * padding + 1; };
        // A quarter of a cell off the walls: no node lies on one.
        origin_ = Vec3f{1, 1, 1} * (-(padding - 0.25f) * edge);
        nx = nodes(scene.size.x);
        ny = nodes(scene.size.y);
        nz = nodes(scene.size.z);
        const auto count = static_cast<double>(nx) * ny * nz;
        if (count > 60e6)
            throw fresco::Error(fmt::format(
                "option \"edge_m\": {:.0f} million grid nodes for this room; expected at most 60 million: set a longer edge",
                count / 1e6));
        bx_ = (nx + block_cells - 1) / block_cells;
        by_ = (ny + block_cells - 1) / block_cells;
        bz_ = (nz + block_cells - 1) / block_cells;
        near_.resize(static_cast<std::size_t>(bx_ * by_ * bz_));
        const float reach = 3 * edge_;
        for (int solid = 0; solid < static_cast<int>(scene_.solids.size()); ++solid)
        {
            const auto& body = scene_.solids[static_cast<std::size_t>(solid)];
            const Vec3f half = half_extent(body) + Vec3f{reach, reach, reach};
            const auto range = [&](float low, float high, float origin, int blocks)
            {
                const float size = edge_ * block_cells;
                return std::pair{std::clamp(static_cast<int>(std::floor((low - origin) / size)), 0, blocks - 1),
                                 std::clamp(static_cast<int>(std::floor((high - origin) / size)), 0, blocks - 1)};
            };
            const auto [x0, x1] = range(body.center.x - half.x, body.center.x + half.x, origin_.x, bx_);
            const auto [y0, y1] = range(body.center.y - half.y, body.center.y + half.y, origin_.y, by_);
            const auto [z0, z1] = range(body.center.z - half.z, body.center.z + half.z, origin_.z, bz_);
            for (int z = z0; z <= z1; ++z)
                for (int y = y0; y <= y1; ++y)
                    for (int x = x0; x <= x1; ++x)
                        near_[static_cast<std::size_t>((z * by_ + y) * bx_ + x)].push_back(solid);
        }
    }

    Vec3f position(GridPoint p) const
    {
        return origin_ + Vec3f{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)} * edge_;
    }
    std::size_t node(GridPoint p) const
    {
        return (static_cast<std::size_t>(p.z) * static_cast<std::size_t>(ny) + static_cast<std::size_t>(p.y)) *
                   static_cast<std::size_t>(nx) +
               static_cast<std::size_t>(p.x);
    }
    const std::vector<int>& near(GridPoint p) const { return near_[block(p)]; }

    /// Distance to the nearest of the listed solids, at most three edges; and which one it is.
    float distance(const std::vector<int>& listed, Vec3f point, int* which = nullptr) const
    {
        float least = 3 * edge_;
        for (const int solid : listed)
            if (const float d = signed_distance(scene_.solids[static_cast<std::size_t>(solid)], point); d < least)
            {
                least = d;
                if (which != nullptr)
                    *which = solid;
            }
        return least;
    }

    std::vector<float> all_nodes(fresco::Progress& progress) const
    {
        std::vector<float> values(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz));
        fresco::parallel_items(nz, 4, progress,
                               [&](int z)
                               {
                                   for (int y = 0; y < ny; ++y)
                                       for (int x = 0; x < nx; ++x)
                                           values[node({x, y, z})] = distance(near({x, y, z}), position({x, y, z}));
                               });
        return values;
    }

    int nx = 0, ny = 0, nz = 0;

  private:
    std::size_t block(GridPoint p) const
    {
        return static_cast<std::size_t>(((p.z / block_cells) * by_ + p.y / block_cells) * bx_ + p.x / block_cells);
    }

    const Scene& scene_;
    float edge_;
    Vec3f origin_;
    int bx_ = 0, by_ = 0, bz_ = 0;
    std::vector<std::vector<int>> near_;
};

constexpr std::array<GridPoint, 8> corners{GridPoint{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                           {0, 0, 1},          {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
constexpr std::array<std::array<std::size_t, 2>, 12> cell_edges{
    {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// Cells that the surface passes, in grid order; `index` gets each cell's vertex.
std::vector<GridPoint> crossed_cells(const DistanceGrid& grid, const std::vector<float>& values,
                                     std::vector<std::uint32_t>& index)
{
    std::vector<GridPoint> cells;
    for (int z = 0; z + 1 < grid.nz; ++z)
        for (int y = 0; y + 1 < grid.ny; ++y)
            for (int x = 0; x + 1 < grid.nx; ++x)
            {
                int solid_corners = 0;
                for (const auto c : corners)
                    solid_corners += values[grid.node({x + c.x, y + c.y, z + c.z})] <= 0 ? 1 : 0;
                if (solid_corners == 0 || solid_corners == 8)
                    continue;
                index[grid.node({x, y, z})] = static_cast<std::uint32_t>(cells.size());
                cells.push_back({x, y, z});
            }
    return cells;
}

Vec3f mean_crossing(const DistanceGrid& grid, const std::vector<float>& values, GridPoint cell)
{
    std::array<float, 8> value{};
    std::array<Vec3f, 8> place{};
    for (std::size_t i = 0; i < 8; ++i)
    {
        const GridPoint p{cell.x + corners[i].x, cell.y + corners[i].y, cell.z + corners[i].z};
        value[i] = values[grid.node(p)];
        place[i] = grid.position(p);
    }
    Vec3f sum;
    int count = 0;
    for (const auto& [a, b] : cell_edges)
        if ((value[a] <= 0) != (value[b] <= 0))
        {
            sum += place[a] + (place[b] - place[a]) * (value[a] / (value[a] - value[b]));
            ++count;
        }
    return sum * (1.0f / static_cast<float>(count));
}

Vec3f gradient(const DistanceGrid& grid, const std::vector<int>& near, Vec3f p, float step)
{
    const auto slope = [&](Vec3f d) { return grid.distance(near, p + d) - grid.distance(near, p - d); };
    return normalized(Vec3f{slope({step, 0, 0}), slope({0, step, 0}), slope({0, 0, step})});
}

/// Two triangles for each grid edge that crosses the surface, between the vertices of the four cells around it.
void connect(const DistanceGrid& grid, const std::vector<float>& values, const std::vector<std::uint32_t>& index, SurfaceNet& net)
{
    constexpr std::array<GridPoint, 3> axes{GridPoint{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const auto quad = [&](std::array<std::uint32_t, 4> v, bool flipped)
    {
        if (flipped)
            std::swap(v[1], v[3]);
        const auto along = [&](std::size_t a, std::size_t b) { return length(net.positions[v[a]] - net.positions[v[b]]); };
        if (along(0, 2) <= along(1, 3))
            net.triangles.insert(net.triangles.end(), {{v[0], v[1], v[2]}, {v[0], v[2], v[3]}});
        else
            net.triangles.insert(net.triangles.end(), {{v[0], v[1], v[3]}, {v[1], v[2], v[3]}});
    };
    for (int z = 1; z + 1 < grid.nz; ++z)
        for (int y = 1; y + 1 < grid.ny; ++y)
            for (int x = 1; x + 1 < grid.nx; ++x)
                for (std::size_t axis = 0; axis < 3; ++axis)
                {
                    const GridPoint a = axes[axis], b = axes[(axis + 1) % 3], c = axes[(axis + 2) % 3];
                    const bool here = values[grid.node({x, y, z})] <= 0;
                    const bool next = values[grid.node({x + a.x, y + a.y, z + a.z})] <= 0;
                    if (here == next)
                        continue;
                    const auto cell = [&](int back_b, int back_c) {
                        return index[grid.node(
                            {x - back_b * b.x - back_c * c.x, y - back_b * b.y - back_c * c.y, z - back_b * b.z - back_c * c.z})];
                    };
                    quad({cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)}, next);
                }
}

}  // namespace

SurfaceNet surface_net(const Scene& scene, float edge, fresco::Progress& progress)
{
    const DistanceGrid grid(scene, edge);
    const auto values = grid.all_nodes(progress);
    std::vector<std::uint32_t> index(values.size(), no_vertex);
    const auto cells = crossed_cells(grid, values, index);
    progress.check_canceled();

    SurfaceNet net;
    net.positions.resize(cells.size());
    net.normals.resize(cells.size());
    net.solids.resize(cells.size());
    fresco::parallel_items(cells.size(), 4096, progress,
                           [&](std::size_t i)
                           {
                               const auto& near = grid.near(cells[i]);
                               Vec3f p = mean_crossing(grid, values, cells[i]);
                               for (int step = 0; step < 2; ++step)
                                   p = p - gradient(grid, near, p, 0.1f * edge) *
                                               std::clamp(grid.distance(near, p), -0.5f * edge, 0.5f * edge);
                               net.positions[i] = p;
                               net.normals[i] = gradient(grid, near, p, 0.1f * edge);
                               grid.distance(near, p, &net.solids[i]);
                           });
    connect(grid, values, index, net);
    return net;
}

namespace
{

constexpr std::size_t crumb_faces = 40;
constexpr float wave_m = 0.35f;

/// Smooth noise in space, standard deviation about 1: three planes of noise.
float waves(Vec3f p, std::uint32_t seed)
{
    const float k = 1 / wave_m;
    const float sum = value_noise(p.x * k, p.y * k, seed) + value_noise(p.y * k, p.z * k, seed + 1) +
                      value_noise(p.z * k, p.x * k, seed + 2) - 1.5f;
    return sum * 2.6f;
}

}  // namespace

fresco::Mesh noisy_mesh(const SurfaceNet& net, const Scene& scene, const LightMap& light, float edge, float noise_m,
                        std::uint32_t seed, fresco::Progress& progress)
{
    fresco::Mesh mesh;
    mesh.triangles = net.triangles;
    mesh.positions.resize(net.positions.size());
    mesh.colors.resize(net.positions.size());
    fresco::parallel_items(
        net.positions.size(), 4096, progress,
        [&](std::size_t i)
        {
            const Vec3f p = net.positions[i];
            const float shift = noise_m * (0.8f * waves(p, seed) + 0.5f * bell(hash(seed, static_cast<std::uint32_t>(i))));
            mesh.positions[i] = p + net.normals[i] * shift;
            const auto& solid = scene.solids[static_cast<std::size_t>(net.solids[i])];
            const int face = nearest_face(solid, p);
            const Vec3f color = light.shade(net.solids[i], face, face_coordinates(solid, face, p), 0.5f * edge);
            const auto level = [](float v) { return static_cast<std::uint8_t>(std::clamp(std::lround(255 * v), 0L, 255L)); };
            mesh.colors[i] = {level(color.x), level(color.y), level(color.z)};
        });
    return mesh;
}

void mark_seen(const std::vector<Vec3f>& positions, const fresco::Raster<float>& exact_depth, const fresco::Camera& camera,
               SeenVertices& seen)
{
    for (std::size_t i = 0; i < positions.size(); ++i)
    {
        const auto pixel = camera.project(fresco::vec_cast<double>(positions[i]));
        if (!(pixel.z > 0.05 && pixel.x >= 0 && pixel.y >= 0 && pixel.x < exact_depth.width && pixel.y < exact_depth.height))
            continue;
        const auto depth = static_cast<double>(exact_depth.at(static_cast<int>(pixel.x), static_cast<int>(pixel.y)));
        if (depth > 0 && std::abs(depth - pixel.z) < 0.015 + 0.012 * pixel.z)
            seen[i].store(1, std::memory_order_relaxed);
    }
}

fresco::Mesh seen_part(const fresco::Mesh& mesh, const SeenVertices& seen, std::vector<Part>& parts)
{
    std::vector<std::size_t> kept;
    fresco::numerics::DisjointSets pieces(mesh.positions.size());
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        if (const auto& t = mesh.triangles[f]; seen[t[0]] != 0 || seen[t[1]] != 0 || seen[t[2]] != 0)
        {
            kept.push_back(f);
            pieces.join(t[0], t[1]);
            pieces.join(t[0], t[2]);
        }
    std::vector<std::size_t> faces(mesh.positions.size());
    for (const std::size_t f : kept)
        ++faces[pieces.find(mesh.triangles[f][0])];
    std::erase_if(kept, [&](std::size_t f) { return faces[pieces.find(mesh.triangles[f][0])] < crumb_faces; });
    if (kept.empty())
        throw fresco::Error("the depth camera saw no surface: set a larger frames_count or larger depth pictures");

    fresco::Mesh part;
    std::vector<Part> kept_parts;
    std::vector<std::uint32_t> named;
    for (const std::size_t f : kept)
    {
        named.insert(named.end(), mesh.triangles[f].begin(), mesh.triangles[f].end());
        kept_parts.push_back(parts[f]);
    }
    for (const auto v : fresco::numerics::number_by_first(named, mesh.positions.size()))
    {
        part.positions.push_back(mesh.positions[v]);
        part.colors.push_back(mesh.colors[v]);
    }
    for (std::size_t i = 0; i < named.size(); i += 3)
        part.triangles.push_back({named[i], named[i + 1], named[i + 2]});
    parts = std::move(kept_parts);
    return part;
}

std::vector<Part> parts_of_faces(const SurfaceNet& net, const Scene& scene)
{
    std::vector<Part> of_vertex;
    for (std::size_t i = 0; i < net.positions.size(); ++i)
    {
        const auto& solid = scene.solids[static_cast<std::size_t>(net.solids[i])];
        constexpr int bottom = 4;
        const int face = solid.hollow ? nearest_face(solid, net.positions[i]) : 0;
        of_vertex.push_back(!solid.hollow    ? solid.part
                            : face == bottom ? Part::floor
                            : face > bottom  ? Part::ceiling
                                             : Part::walls);
    }
    std::vector<Part> result;
    for (const auto& t : net.triangles)
        result.push_back(of_vertex[t[1]] == of_vertex[t[2]] ? of_vertex[t[1]] : of_vertex[t[0]]);
    return result;
}

}  // namespace room

#include <fresco/rendering/raster_finder.h>

#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace fresco::rendering
{
namespace
{

/// Surface nearer to the camera's plane than this is cut away, in meters.
constexpr double near_m = 1e-5;

}  // namespace

Frustum::Frustum(const Intrinsics& k)
{
    const auto box = [&](double margin)
    {
        return Box{(-margin * k.width - k.cx) / k.fx, ((1 + margin) * k.width - k.cx) / k.fx, (-margin * k.height - k.cy) / k.fy,
                   ((1 + margin) * k.height - k.cy) / k.fy};
    };
    picture = box(0);
    guard = box(1);
}

Projected Frustum::project(Vec3d point) const
{
    const auto beyond = [&](const Box& box)
    {
        return static_cast<std::uint8_t>((point.x < box.left * point.z ? left : 0) | (point.x > box.right * point.z ? right : 0) |
                                         (point.y < box.above * point.z ? above : 0) |
                                         (point.y > box.below * point.z ? below : 0));
    };
    Projected result;
    result.sides = beyond(picture);
    if (point.z < near_m)
    {
        result.sides |= behind;
        return result;
    }
    if (result.sides != 0 && beyond(guard) != 0)
    {
        result.sides |= far_aside;
        return result;
    }
    const double nearness = 1 / point.z;
    result.x = point.x * nearness;
    result.y = point.y * nearness;
    result.nearness = static_cast<float>(nearness);
    return result;
}

bool Frustum::misses(Vec3d center, double radius) const
{
    const auto beyond = [&](double aside, double slope) { return aside > radius * std::sqrt(1 + slope * slope); };
    return center.z + radius < near_m || beyond(picture.left * center.z - center.x, picture.left) ||
           beyond(center.x - picture.right * center.z, picture.right) ||
           beyond(picture.above * center.z - center.y, picture.above) ||
           beyond(center.y - picture.below * center.z, picture.below);
}

namespace
{

/// With two zeros before each of the lowest ten bits.
std::uint32_t spread(std::uint32_t n)
{
    n = (n | n << 16) & 0x030000FF;
    n = (n | n << 8) & 0x0300F00F;
    n = (n | n << 4) & 0x030C30C3;
    return (n | n << 2) & 0x09249249;
}

/// The faces along a space-filling curve (Morton, 1966) through their first corners.
std::vector<std::uint32_t> faces_by_place(const Mesh& mesh)
{
    if (mesh.triangles.empty())
        return {};
    numerics::Bounds<float> bounds;
    for (const Triangle& t : mesh.triangles)
        bounds.add(mesh.positions[t[0]]);
    const Vec3f size = bounds.high - bounds.low;
    const float most = std::max({size.x, size.y, size.z, std::numeric_limits<float>::min()});
    const auto cell = [&](float along) { return spread(static_cast<std::uint32_t>(along / most * 1023.0F)); };
    std::vector<std::uint64_t> keys(mesh.triangles.size());
    for (std::size_t f = 0; f < keys.size(); ++f)
    {
        const Vec3f p = mesh.positions[mesh.triangles[f][0]] - bounds.low;
        keys[f] = (std::uint64_t{cell(p.x) | cell(p.y) << 1 | cell(p.z) << 2} << 32) | f;
    }
    std::ranges::sort(keys);
    std::vector<std::uint32_t> faces(keys.size());
    std::ranges::transform(keys, faces.begin(), [](std::uint64_t key) { return static_cast<std::uint32_t>(key); });
    return faces;
}

/// A ball around the corners; a little larger, as it may be in the frame of a camera whose pose is a rotation to two digits only
/// (check_camera).
FaceClusters::Ball ball_around(const Mesh& mesh, std::span<const std::uint32_t> vertices)
{
    numerics::Bounds<float> bounds;
    for (const std::uint32_t v : vertices)
        bounds.add(mesh.positions[v]);
    const Vec3f center = (bounds.low + bounds.high) * 0.5F;
    double squared = 0;
    for (const std::uint32_t v : vertices)
    {
        const Vec3d arm = vec_cast<double>(mesh.positions[v]) - vec_cast<double>(center);
        squared = std::max(squared, dot(arm, arm));
    }
    return {center, static_cast<float>(std::sqrt(squared) * 1.02 + 1e-6)};
}

}  // namespace

FaceClusters::FaceClusters(const Mesh& mesh) : faces_(faces_by_place(mesh)), corners_(faces_.size()), first_vertex_{0}
{
    std::vector<std::uint32_t> vertices;
    for (std::size_t begin = 0; begin < faces_.size(); begin += most_faces)
    {
        const std::size_t end = std::min(begin + most_faces, faces_.size());
        vertices.clear();
        for (std::size_t i = begin; i < end; ++i)
            vertices.insert(vertices.end(), mesh.triangles[faces_[i]].begin(), mesh.triangles[faces_[i]].end());
        std::ranges::sort(vertices);
        const auto repeated = std::ranges::unique(vertices);
        vertices.erase(repeated.begin(), repeated.end());
        for (std::size_t i = begin; i < end; ++i)
        {
            for (std::size_t corner = 0; corner < 3; ++corner)
            {
                const auto place = std::ranges::lower_bound(vertices, mesh.triangles[faces_[i]][corner]);
                corners_[i][corner] = static_cast<std::uint8_t>(place - vertices.begin());
            }
            std::ranges::sort(corners_[i]);
        }
        balls_.push_back(ball_around(mesh, vertices));
        vertices_.insert(vertices_.end(), vertices.begin(), vertices.end());
        first_vertex_.push_back(static_cast<std::uint32_t>(vertices_.size()));
    }
}

std::span<const std::uint32_t> FaceClusters::faces(std::size_t cluster) const
{
    return std::span(faces_).subspan(first_face(cluster), first_face(cluster + 1) - first_face(cluster));
}

std::span<const std::uint32_t> FaceClusters::vertices(std::size_t cluster) const
{
    return std::span(vertices_).subspan(first_vertex_[cluster], first_vertex_[cluster + 1] - first_vertex_[cluster]);
}

std::span<const std::array<std::uint8_t, 3>> FaceClusters::corners(std::size_t cluster) const
{
    return std::span(corners_).subspan(first_face(cluster), first_face(cluster + 1) - first_face(cluster));
}

namespace
{

/// The side on which normal . p >= offset is kept.
struct HalfSpace
{
    Vec3d normal;
    double offset;

    double inside(Vec3d p) const { return dot(normal, p) - offset; }
};

struct Polygon
{
    std::array<Vec3d, Clipped::most_corners> corners;
    std::size_t count = 0;

    void add(Vec3d corner) { corners[count++] = corner; }
};

bool before(Vec3d a, Vec3d b)
{
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// Intersection of an edge with the plane; both directions of the edge give the same point.
Vec3d meeting(Vec3d a, Vec3d b, const HalfSpace& half)
{
    if (before(b, a))
        std::swap(a, b);
    const double at_a = half.inside(a);
    const double at_b = half.inside(b);
    return a + (b - a) * (at_a / (at_a - at_b));
}

Polygon cut(const Polygon& polygon, const HalfSpace& half)
{
    Polygon result;
    for (std::size_t i = 0; i < polygon.count; ++i)
    {
        const Vec3d from = polygon.corners[i];
        const Vec3d to = polygon.corners[(i + 1) % polygon.count];
        const bool from_inside = half.inside(from) >= 0;
        const bool to_inside = half.inside(to) >= 0;
        if (from_inside)
            result.add(from);
        if (from_inside != to_inside)
            result.add(meeting(from, to, half));
    }
    return result;
}

}  // namespace

Clipped clipped(const std::array<Vec3d, 3>& triangle, const Frustum& frustum)
{
    const auto& guard = frustum.guard;
    const std::array<HalfSpace, 5> halves{{{{0, 0, 1}, near_m},
                                           {{1, 0, -guard.left}, 0},
                                           {{-1, 0, guard.right}, 0},
                                           {{0, 1, -guard.above}, 0},
                                           {{0, -1, guard.below}, 0}}};
    Polygon polygon;
    for (const Vec3d corner : triangle)
        polygon.add(corner);
    for (const HalfSpace& half : halves)
        polygon = cut(polygon, half);
    Clipped result;
    for (std::size_t i = 0; i < polygon.count; ++i)
    {
        const Vec3d p = polygon.corners[i];
        const double nearness = 1 / std::max(p.z, near_m);
        // Corners cut from very far ones are known to few digits; beyond the guard they would overflow.
        const double x = std::min(std::max(p.x * nearness, guard.left), guard.right);
        const double y = std::min(std::max(p.y * nearness, guard.above), guard.below);
        result.corners[result.count++] = {x, y, static_cast<float>(nearness), 0};
    }
    return result;
}

namespace
{

/// Twice the area of the triangle that an edge from (x, y) along (dx, dy) forms with a point: above 0 inside.
struct Edge
{
    std::int64_t x, y, dx, dy;

    std::int64_t at(std::int64_t px, std::int64_t py) const { return dx * (py - y) - dy * (px - x); }
    /// -1 where points on the edge itself are outside.
    std::int64_t bias() const { return dy > 0 || (dy == 0 && dx > 0) ? 0 : -1; }
};

/// The edge from corner i to corner j; `way` is -1 for a piece that runs the other way round.
Edge edge_of(const Piece& piece, std::size_t i, std::size_t j, std::int64_t way)
{
    return {piece.x[i], piece.y[i], way * (std::int64_t{piece.x[j]} - piece.x[i]), way * (std::int64_t{piece.y[j]} - piece.y[i])};
}

std::uint64_t key(float nearness, std::uint32_t face)
{
    return (std::uint64_t{std::bit_cast<std::uint32_t>(nearness)} << 32) | (~face & 0xFFFFFFFFU);
}

}  // namespace

const TileKernel& fastest_kernel()
{
    static const auto& fastest = fastest_of(avx512_kernel(), avx2_kernel(), base_kernel());
    return fastest;
}

void Tile::clear(int x, int y)
{
    x_ = x;
    y_ = y;
    keys_.fill(0);
}

void Tile::row(int row, int columns, std::uint32_t* faces) const
{
    const std::uint64_t* keys = keys_.data() + std::ptrdiff_t{row} * tile_stride;
    for (int i = 0; i < columns; ++i)
        faces[i] = ~static_cast<std::uint32_t>(keys[i]);
}

void draw_wide(const Piece& piece, int bits, int tile_x, int tile_y, std::uint64_t* keys)
{
    const auto [x_min, x_max] = std::minmax({piece.x[0], piece.x[1], piece.x[2]});
    const auto [y_min, y_max] = std::minmax({piece.y[0], piece.y[1], piece.y[2]});
    const int round_up = (1 << bits) - 1;
    const int first_x = std::max((x_min + round_up) >> bits, tile_x);
    const int first_y = std::max((y_min + round_up) >> bits, tile_y);
    const int last_x = std::min(x_max >> bits, tile_x + tile_width - 1);
    const int last_y = std::min(y_max >> bits, tile_y + tile_height - 1);
    if (first_x > last_x || first_y > last_y)
        return;

    const std::int64_t area = edge_of(piece, 0, 1, 1).at(piece.x[2], piece.y[2]);
    if (area == 0)
        return;
    const std::int64_t way = area > 0 ? 1 : -1;
    const Edge a = edge_of(piece, 1, 2, way);
    const Edge b = edge_of(piece, 2, 0, way);
    const Edge c = edge_of(piece, 0, 1, way);
    const std::int64_t px = std::int64_t{first_x} << bits;
    const std::int64_t py = std::int64_t{first_y} << bits;
    std::int64_t row_a = a.at(px, py) + a.bias();
    std::int64_t row_b = b.at(px, py) + b.bias();
    std::int64_t row_c = c.at(px, py) + c.bias();

    // Nearness is linear in the picture: that of corner 0 and shares of the differences to the others.
    const double share = 1 / static_cast<double>(way * area);
    const double to_b = (double{piece.nearness[1]} - double{piece.nearness[0]}) * share;
    const double to_c = (double{piece.nearness[2]} - double{piece.nearness[0]}) * share;
    for (int y = first_y; y <= last_y; ++y)
    {
        std::int64_t at_a = row_a;
        std::int64_t at_b = row_b;
        std::int64_t at_c = row_c;
        std::uint64_t* row = keys + std::ptrdiff_t{y - tile_y} * tile_stride;
        for (int x = first_x; x <= last_x; ++x)
        {
            if ((at_a | at_b | at_c) >= 0)
            {
                const double nearness =
                    double{piece.nearness[0]} + (static_cast<double>(at_b) * to_b + static_cast<double>(at_c) * to_c);
                std::uint64_t& seen = row[x - tile_x];
                seen = std::max(seen, key(static_cast<float>(nearness), piece.face));
            }
            at_a -= a.dy << bits;
            at_b -= b.dy << bits;
            at_c -= c.dy << bits;
        }
        row_a += a.dx << bits;
        row_b += b.dx << bits;
        row_c += c.dx << bits;
    }
}

Grid::Grid(const Intrinsics& k, std::uint32_t first)
    : width(k.width), height(k.height), bits(16), tiles_across((k.width + Tile::width - 1) / Tile::width), first_tile(first)
{
    // The guard of the frustum reaches from minus one picture to plus two.
    while (2 * std::int64_t{std::max(width, height)} << bits > coordinate_limit)
        --bits;
    const double one = 1 << bits;
    scale_x = k.fx * one;
    scale_y = k.fy * one;
    shift_x = (k.cx - 0.5) * one;
    shift_y = (k.cy - 0.5) * one;
    const int tiles_down = (k.height + Tile::height - 1) / Tile::height;
    end_tile = first + static_cast<std::uint32_t>(tiles_across) * static_cast<std::uint32_t>(tiles_down);
}

void TileBins::fill(const Mesh& mesh, const FaceClusters& clusters, std::size_t begin, std::size_t end, const Frustum& frustum,
                    const IntoCamera& into_camera, const std::vector<Grid>& grids, bool through_backs)
{
    const auto is_front = [&](const Triangle& t)
    {
        const auto corner = [&](std::size_t i) { return into_camera.point(mesh.positions[t[i]]); };
        return dot(corner(0), cross(corner(1), corner(2))) < 0;
    };
    pieces_.clear();
    entries_.clear();
    std::array<Projected, FaceClusters::most_vertices> projected;
    for (std::size_t cluster = begin; cluster < end; ++cluster)
    {
        const auto& [center, radius] = clusters.ball(cluster);
        if (frustum.misses(into_camera.point(center), double{radius}))
            continue;
        const std::span vertices = clusters.vertices(cluster);
        for (std::size_t v = 0; v < vertices.size(); ++v)
            projected[v] = frustum.project(into_camera.point(mesh.positions[vertices[v]]));
        const std::span faces = clusters.faces(cluster);
        for (std::size_t i = 0; i < faces.size(); ++i)
        {
            const auto& corners = clusters.corners(cluster)[i];
            const Projected& a = projected[corners[0]];
            const Projected& b = projected[corners[1]];
            const Projected& c = projected[corners[2]];
            if (out_of_sight(a.sides, b.sides, c.sides) || (through_backs && !is_front(mesh.triangles[faces[i]])))
                continue;
            if (!needs_clipping(a.sides, b.sides, c.sides))
            {
                add(faces[i], a, b, c, grids);
                continue;
            }
            const auto corner = [&](std::size_t n) { return into_camera.point(mesh.positions[vertices[corners[n]]]); };
            const Clipped part = clipped({corner(0), corner(1), corner(2)}, frustum);
            for (std::size_t n = 2; n < part.count; ++n)
                add(faces[i], part.corners[0], part.corners[n - 1], part.corners[n], grids);
        }
    }
    sort(grids.back().end_tile);
}

void TileBins::add(std::uint32_t face, const Projected& a, const Projected& b, const Projected& c, const std::vector<Grid>& grids)
{
    for (const Grid& grid : grids)
    {
        const Piece piece{
            {grid.x(a), grid.x(b), grid.x(c)}, {grid.y(a), grid.y(b), grid.y(c)}, {a.nearness, b.nearness, c.nearness}, face};
        // Comparing two at a time takes no branches, which corners in any order would mislead.
        const auto least = [](const auto& of) { return std::min(std::min(of[0], of[1]), of[2]); };
        const auto most = [](const auto& of) { return std::max(std::max(of[0], of[1]), of[2]); };
        const int round_up = (1 << grid.bits) - 1;
        const int first_x = std::max((least(piece.x) + round_up) >> grid.bits, 0);
        const int first_y = std::max((least(piece.y) + round_up) >> grid.bits, 0);
        const int last_x = std::min(most(piece.x) >> grid.bits, grid.width - 1);
        const int last_y = std::min(most(piece.y) >> grid.bits, grid.height - 1);
        if (first_x > last_x || first_y > last_y)
            continue;
        const auto number = static_cast<std::uint32_t>(pieces_.size());
        pieces_.push_back(piece);
        for (int y = first_y / Tile::height; y <= last_y / Tile::height; ++y)
            for (int x = first_x / Tile::width; x <= last_x / Tile::width; ++x)
                entries_.push_back({grid.first_tile + static_cast<std::uint32_t>(y * grid.tiles_across + x), number});
    }
}

void TileBins::sort(std::uint32_t tiles)
{
    starts_.assign(std::size_t{tiles} + 1, 0);
    for (const Entry& entry : entries_)
        ++starts_[entry.tile + 1];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    sorted_.resize(entries_.size());
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (const Entry& entry : entries_)
        sorted_[next[entry.tile]++] = entry.piece;
}

namespace
{

constexpr std::size_t clusters_per_block = 256;
/// Every block has a count per tile, which shall not outgrow the faces.
constexpr std::size_t most_blocks = 256;
constexpr std::size_t tiles_at_once = 4;

/// Draws the tile of that number and copies it into the picture.
void draw_tile(const Grid& grid, std::uint32_t number, const std::vector<TileBins>& bins, Tile& tile, FaceMap& faces)
{
    const auto place = static_cast<int>(number - grid.first_tile);
    const int x = place % grid.tiles_across * Tile::width;
    const int y = place / grid.tiles_across * Tile::height;
    tile.clear(x, y);
    for (const TileBins& some : bins)
        tile.draw(some.pieces(), some.pieces_of(number), grid.bits);
    const int columns = std::min(Tile::width, grid.width - x);
    for (int row = 0; row < std::min(Tile::height, grid.height - y); ++row)
        tile.row(row, columns, &faces.at(x, y + row));
}

}  // namespace

void RasterFinder::find(std::span<const Camera> cameras, const Progress& progress, std::span<FaceMap> faces)
{
    if (cameras.empty())
        return;
    const Camera& camera = cameras.front();
    const Frustum frustum(camera.intrinsics);
    const IntoCamera into_camera(camera.world_from_camera);

    std::vector<Grid> grids;
    std::vector<std::size_t> picture_of;
    for (const Camera& sized : cameras)
    {
        grids.emplace_back(sized.intrinsics, grids.empty() ? 0 : grids.back().end_tile);
        picture_of.resize(grids.back().end_tile, grids.size() - 1);
    }
    const std::size_t count = clusters_->count();
    const std::size_t block = std::max(clusters_per_block, (count + most_blocks - 1) / most_blocks);
    bins_.resize((count + block - 1) / block);
    parallel_for(count, block, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     bins_[begin / block].fill(mesh_, *clusters_, begin, end, frustum, into_camera, grids, through_backs_);
                 });
    parallel_for(picture_of.size(), tiles_at_once, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     Tile tile;
                     for (std::size_t number = begin; number < end; ++number)
                     {
                         const std::size_t picture = picture_of[number];
                         draw_tile(grids[picture], static_cast<std::uint32_t>(number), bins_, tile, faces[picture]);
                     }
                 });
}

}  // namespace fresco::rendering

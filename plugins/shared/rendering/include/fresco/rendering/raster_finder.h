#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/rendering/tile_kernel.h>
#include <fresco/uv_mapping/into_camera.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

/// \file Finds the face at each pixel by rasterization: passes over what lies aside, projects the rest, clips the faces, sorts
/// them into tiles of the pictures, and draws the tiles on all threads. RasterFinder does it all; the steps are declared for
/// tests.

namespace fresco::rendering
{

/// A point as the camera sees it, for any size of its pictures.
struct Projected
{
    double x = 0;            ///< X / Z in the camera; 0 if `sides` requires clipping.
    double y = 0;            ///< Y / Z, likewise.
    float nearness = 0;      ///< 1 / Z, per meter.
    std::uint8_t sides = 0;  ///< The planes whose far side it lies on: flags of Frustum.
};

/// The planes around a camera's view: through its center and the picture's borders; the plane near_m before it; and planes
/// through the center a picture's size beyond the borders, which keep coordinates small.
struct Frustum
{
    static constexpr std::uint8_t left = 1;
    static constexpr std::uint8_t right = 2;
    static constexpr std::uint8_t above = 4;
    static constexpr std::uint8_t below = 8;
    static constexpr std::uint8_t behind = 16;
    static constexpr std::uint8_t far_aside = 32;

    /// Bounds of X / Z and Y / Z.
    struct Box
    {
        double left, right, above, below;
    };
    Box picture;
    Box guard;

    explicit Frustum(const Intrinsics& intrinsics);

    /// `point`: in the camera's frame.
    Projected project(Vec3d point) const;
    /// Whether a ball lies beyond one of the planes of `out_of_sight`. `center`: in the camera's frame.
    bool misses(Vec3d center, double radius) const;
};

/// Whether all three corners lie beyond one plane, so that the face is not seen.
inline bool out_of_sight(std::uint8_t a, std::uint8_t b, std::uint8_t c)
{
    return (a & b & c & ~Frustum::far_aside) != 0;
}
inline bool needs_clipping(std::uint8_t a, std::uint8_t b, std::uint8_t c)
{
    return ((a | b | c) & (Frustum::behind | Frustum::far_aside)) != 0;
}

/// The faces of a mesh in clusters of neighbors, of which a camera sees all or none in most cases.
class FaceClusters
{
  public:
    static constexpr std::size_t most_faces = 64;
    static constexpr std::size_t most_vertices = 3 * most_faces;

    explicit FaceClusters(const Mesh& mesh);

    std::size_t count() const { return balls_.size(); }

    struct Ball
    {
        Vec3f center;
        float radius;
    };
    /// Holds all corners of the cluster.
    const Ball& ball(std::size_t cluster) const { return balls_[cluster]; }
    /// Faces of a cluster, by their numbers in the mesh.
    std::span<const std::uint32_t> faces(std::size_t cluster) const;
    /// The vertices of its faces in the mesh, ascending.
    std::span<const std::uint32_t> vertices(std::size_t cluster) const;
    /// Per face, its corners' places among the vertices, ascending: in one order whatever the face begins with, so that faces
    /// with the same corners get the same depths, and the first one is seen.
    std::span<const std::array<std::uint8_t, 3>> corners(std::size_t cluster) const;

  private:
    std::size_t first_face(std::size_t cluster) const { return std::min(cluster * most_faces, faces_.size()); }

    std::vector<Ball> balls_;
    std::vector<std::uint32_t> faces_;
    std::vector<std::array<std::uint8_t, 3>> corners_;  ///< Corners of `faces_`.
    std::vector<std::uint32_t> vertices_;
    std::vector<std::uint32_t> first_vertex_;  ///< First vertex of each cluster, and the end.
};

/// The part of a triangle that lies before the near plane and between the frustum's outer planes.
struct Clipped
{
    /// One more than a triangle's for each of the five planes; half as many more each, because rounding may bend the polygon.
    static constexpr std::size_t most_corners = 19;

    std::array<Projected, most_corners> corners;
    std::size_t count = 0;  ///< 0: all was cut away.
};

/// Cuts a triangle, given in the camera's frame, plane by plane (Sutherland and Hodgman, "Reentrant polygon clipping", 1974). Two
/// triangles that share an edge get equal corners on it, bit by bit.
Clipped clipped(const std::array<Vec3d, 3>& triangle, const Frustum& frustum);

/// Coordinates stay below this, so that products of their differences fit into 64 bits.
inline constexpr std::int32_t coordinate_limit = 1 << 29;

/// The faces that pixels see in one rectangle of the picture. A pixel on the common edge of two pieces belongs to exactly one of
/// them: edge functions (Pineda, "A parallel algorithm for polygon rasterization", 1988) are computed in integers, without
/// rounding, and an edge belongs to the piece for which it runs down, or to the right if it is level. The nearest piece wins, of
/// equally near ones that of the first face; the order of drawing does not matter.
class Tile
{
  public:
    static constexpr int width = tile_width;
    static constexpr int height = tile_height;

    /// Empties the tile and places its first pixel at (x, y).
    void clear(int x, int y);

    /// Draws the pieces with these numbers, in either orientation; one without area covers no pixel. `bits`: fractional bits of
    /// their coordinates.
    void draw(std::span<const Piece> pieces, std::span<const std::uint32_t> numbers, int bits,
              const TileKernel& kernel = fastest_kernel())
    {
        kernel.draw(pieces.data(), numbers.data(), numbers.size(), bits, x_, y_, keys_.data());
    }

    /// The faces of `columns` pixels from the tile's left border in its row `row`; no_face for pixels without a piece.
    void row(int row, int columns, std::uint32_t* faces) const;

  private:
    int x_ = 0;
    int y_ = 0;
    /// Nearness, whose bits are ordered as positive numbers are, above the complement of the face: the greatest is seen.
    std::array<std::uint64_t, std::size_t{tile_stride} * height> keys_{};
};

/// A picture cut into tiles.
struct Grid
{
    int width = 0;
    int height = 0;
    int bits = 0;  ///< Fractional bits of coordinates: 16, fewer for pictures wider or higher than 4096.
    double scale_x = 0;
    double scale_y = 0;
    double shift_x = 0;
    double shift_y = 0;
    int tiles_across = 0;
    std::uint32_t first_tile = 0;  ///< Tiles of all pictures are counted through, row by row.
    std::uint32_t end_tile = 0;

    Grid(const Intrinsics& intrinsics, std::uint32_t first_tile);

    std::int32_t x(const Projected& p) const { return rounded(p.x * scale_x + shift_x); }
    std::int32_t y(const Projected& p) const { return rounded(p.y * scale_y + shift_y); }

  private:
    static std::int32_t rounded(double value)
    {
        // Adding 1.5 * 2^52 leaves the nearest whole number in the low bits, quicker than functions that heed the rounding mode.
        return static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(value + 6755399441055744.0));
    }
};

/// The pieces of a range of faces, sorted by the tiles whose pixels they may cover.
class TileBins
{
  public:
    /// Bins the faces of the clusters [begin, end) for all pictures, with `through_backs` only those that are seen from their
    /// front. Reuses the memory of the last call.
    void fill(const Mesh& mesh, const FaceClusters& clusters, std::size_t begin, std::size_t end, const Frustum& frustum,
              const IntoCamera& into_camera, const std::vector<Grid>& grids, bool through_backs = false);

    std::span<const std::uint32_t> pieces_of(std::uint32_t tile) const
    {
        return std::span(sorted_).subspan(starts_[tile], starts_[tile + 1] - starts_[tile]);
    }
    std::span<const Piece> pieces() const { return pieces_; }

  private:
    struct Entry
    {
        std::uint32_t tile;
        std::uint32_t piece;
    };

    void add(std::uint32_t face, const Projected& a, const Projected& b, const Projected& c, const std::vector<Grid>& grids);
    void sort(std::uint32_t tiles);

    std::vector<Piece> pieces_;
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> starts_;
    std::vector<std::uint32_t> sorted_;
};

/// Finds the face at each pixel by drawing the mesh's faces into a depth buffer, a tile at a time. Vertices are projected in
/// double precision and snapped to 1/65536 of a pixel (coarser beyond 4096 px), so that every pixel on the common edge of two
/// faces belongs to exactly one of them. Memory: 12 bytes per face of the mesh, which copies share, and some 44 per face in sight
/// and size.
class RasterFinder final : public FaceFinder
{
  public:
    /// The mesh must have passed check_mesh and must outlive the finder. `through_backs`: faces seen from their back are not
    /// there.
    explicit RasterFinder(const Mesh& mesh, bool through_backs = false)
        : mesh_(mesh), clusters_(std::make_shared<FaceClusters>(mesh)), through_backs_(through_backs)
    {
    }

    void find(std::span<const Camera> cameras, const Progress& progress, std::span<FaceMap> faces) override;

  private:
    const Mesh& mesh_;
    std::shared_ptr<const FaceClusters> clusters_;
    bool through_backs_;
    std::vector<TileBins> bins_;
};

}  // namespace fresco::rendering

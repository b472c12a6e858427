#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/parallel.h>

#include <array>
#include <compare>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

/// \file Fuses depth pictures into a volume of signed distances: depth_view() fits a plane to each pixel, OpenedBlocks finds the
/// blocks of the volume that a view needs, and integrate() averages the views into their voxels. The stage opens blocks over all
/// frames first, integrates then, and takes the mesh from the volume (surface.h).

namespace fuse
{

inline constexpr int block_side = 8;  ///< Voxels.
inline constexpr std::size_t block_size = std::size_t{block_side} * block_side * block_side;

/// The position of a block: voxels [8 x, 8 x + 8) along x, and so on. Voxel i lies at i times the voxel's side from the world's
/// origin.
struct BlockPlace
{
    int x = 0, y = 0, z = 0;
    friend auto operator<=>(const BlockPlace&, const BlockPlace&) = default;
};

/// The weighted mean of the measurements at a point, as sums. Distances are positive in front of the surface.
struct Voxel
{
    float distance_sum = 0;  ///< Meters, times weights.
    float weight = 0;        ///< 0: no measurement.

    float distance() const { return distance_sum / weight; }
};

/// Voxels by x first, then y, then z.
using Block = std::array<Voxel, block_size>;

constexpr std::size_t voxel_index(int x, int y, int z)
{
    return static_cast<std::size_t>(x + block_side * (y + block_side * z));
}

/// Signed distances in blocks near the seen surface.
class Volume
{
  public:
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    static constexpr std::size_t bytes_per_block = sizeof(Block) + sizeof(BlockPlace);

    /// `places`: sorted, each once.
    Volume(double voxel_m, std::vector<BlockPlace> places);

    double voxel_m() const { return voxel_m_; }
    const std::vector<BlockPlace>& places() const { return places_; }
    /// The index of a block; `none` if it does not exist.
    std::size_t find(BlockPlace place) const;
    const Block& block(std::size_t index) const { return blocks_[index]; }
    Block& block(std::size_t index) { return blocks_[index]; }
    /// The position of a block's first voxel in meters.
    fresco::Vec3d origin(std::size_t block) const;
    std::size_t bytes() const { return places_.size() * bytes_per_block; }

  private:
    double voxel_m_;
    std::vector<BlockPlace> places_;
    std::vector<Block> blocks_;
};

/// The surface at one depth pixel, as a plane in the camera's frame that faces the camera.
struct PixelPlane
{
    fresco::Vec3f normal;
    float offset = 0;
    float weight = 0;  ///< Weight of the measurement; 0: none.

    /// Meters in front of the plane, for a point in the camera's frame.
    float distance(fresco::Vec3f point) const { return dot(normal, point) + offset; }
};

/// A depth picture with the planes of its pixels.
struct DepthView
{
    fresco::Camera camera;
    fresco::RasterF depth;  ///< Meters along the optical axis, 0 for pixels without a plane.
    fresco::Raster<PixelPlane> planes;
};

/// Fits a plane to the inverse depths around each pixel: they are linear in a picture of a plane, and the noise of structured
/// light and stereo is about the same everywhere in them. Ignores depths that are not positive or beyond `max_depth_m`, surfaces
/// seen at less than 12 degrees, the picture's border, and pixels beside depth edges and wide holes: their plane must continue in
/// six of their eight neighbors. Beside narrow holes and in holes of a pixel it must reach five more closely, three of them
/// neighbors, the others across a hole of a pixel: such pixels count less, the less the fewer neighbors continue them, so that
/// perforated depth does not fray. The weight of a pixel is the cosine of its viewing angle over the square of its depth.
DepthView depth_view(const fresco::RasterF& depth, const fresco::Camera& camera, double max_depth_m);

/// Finds the blocks that a volume needs: those within `reach_m` of a measured point along each axis.
struct OpenedBlocks
{
    double voxel_m;
    double reach_m;
    std::size_t most;  ///< The search stops after this many blocks and one more.

    /// The blocks of one view, sorted and unique.
    std::vector<BlockPlace> near(const DepthView& view) const;
};

/// Adds the places in `more`. Both are sorted and unique.
void unite(std::vector<BlockPlace>& places, const std::vector<BlockPlace>& more);

/// Averages the views' measurements into the voxels. A voxel that a camera sees gets its distance from the plane of the pixel
/// that it projects to, at most `truncation_m`. Behind the plane its weight falls from one voxel on, and is 0 from `truncation_m`
/// on. `truncation_m` is at least a voxel. Each block is handled by one thread, which takes the views in order: the result does
/// not depend on the number of threads. Curless and Levoy, "A volumetric method for building complex models from range images"
/// (1996).
void integrate(std::span<const DepthView> views, double truncation_m, const fresco::Progress& progress, Volume& volume);

}  // namespace fuse

#pragma once

#include <fresco/math.h>

#include <array>
#include <compare>
#include <cstddef>
#include <limits>
#include <vector>

namespace fuse
{

inline constexpr int block_side = 8;  ///< Voxels.
inline constexpr std::size_t block_size = std::size_t{block_side} * block_side * block_side;

/// Where a block is: voxels [8 x, 8 x + 8) along x, and so on. Voxel i lies at i times the voxel's side from the world's origin.
struct BlockPlace
{
    int x = 0, y = 0, z = 0;
    friend auto operator<=>(const BlockPlace&, const BlockPlace&) = default;
};

/// The weighted mean of what was measured at a point, as sums. Distances are positive in front of the surface.
struct Voxel
{
    float distance_sum = 0;  ///< Meters, times weights.
    float weight = 0;        ///< 0: nothing was measured here.

    float distance() const { return distance_sum / weight; }
};

/// Voxels by x first, then y, then z.
using Block = std::array<Voxel, block_size>;

constexpr std::size_t voxel_index(int x, int y, int z)
{
    return static_cast<std::size_t>(x + block_side * (y + block_side * z));
}

/// Signed distances in blocks, where a surface was seen.
class Volume
{
  public:
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    static constexpr std::size_t bytes_per_block = sizeof(Block) + sizeof(BlockPlace);

    /// `places`: sorted, each once.
    Volume(double voxel_m, std::vector<BlockPlace> places);

    double voxel_m() const { return voxel_m_; }
    const std::vector<BlockPlace>& places() const { return places_; }
    /// `none` without such a block.
    std::size_t find(BlockPlace place) const;
    const Block& block(std::size_t index) const { return blocks_[index]; }
    Block& block(std::size_t index) { return blocks_[index]; }
    /// Where a block's first voxel is.
    fresco::Vec3d origin(std::size_t block) const;
    std::size_t bytes() const { return places_.size() * bytes_per_block; }

  private:
    double voxel_m_;
    std::vector<BlockPlace> places_;
    std::vector<Block> blocks_;
};

}  // namespace fuse

#pragma once

#include <fresco/math.h>

#include <cstddef>
#include <vector>

namespace fresco::face_blocks
{

/// Square blocks of texels in a square texture, row by row from the lower left.
struct Layout
{
    int size_px;
    int block_px;  ///< At least 2.

    std::size_t blocks_per_row() const { return static_cast<std::size_t>(size_px / block_px); }
    std::size_t blocks_count() const { return blocks_per_row() * blocks_per_row(); }
};

/// How far the corners lie inside the centers of their texels, in texels: no rounding of a uv down to half of this makes a lookup
/// touch the block beside.
inline constexpr double inset_px = 1.0 / 16;

/// Three uv per face, counter-clockwise: the first corner at the lower left texel's center of the face's own block, the second at
/// the lower right one's, the third at the upper left one's, each inset_px inside. `faces` <= blocks_count(). A bilinear lookup
/// inside the triangle reads only texels of the block.
std::vector<Vec2f> texcoords(std::size_t faces, const Layout& layout);

/// The smallest texture, a power of two, with room for so many blocks.
int smallest_size_px(std::size_t faces, int block_px);

}  // namespace fresco::face_blocks

#pragma once

#include <fresco/image.h>

#include <array>
#include <cstdint>
#include <vector>

/// \file Fine detail of a picture, block by block.

namespace fresco::sharpest
{

/// Directions along which pictures are compared with themselves: right, down, and the two diagonals.
inline constexpr std::size_t directions_count = 4;
/// Distances, in steps along a direction.
inline constexpr std::array<int, 4> lags{1, 2, 4, 8};
inline constexpr int block_px = 16;
/// Height at which detail is measured; smaller pictures are measured as they are.
inline constexpr int measured_height_px = 480;

/// Pixels from one step to the next.
double step_px(std::size_t direction);

/// Of one block: the mean squared difference of gray levels (0..255) between pixels a lag apart, and the mean gray level.
///
/// The change at lag n, divided by n², is the change at lag 1 that the picture would have if it were blurred along the direction
/// by n steps: the difference of neighbors in the mean of n pixels is that of its ends, divided by n.
struct BlockDetail
{
    std::array<std::array<float, lags.size()>, directions_count> change{};
    float gray = 0;
};

struct Detail
{
    int columns = 0;
    int rows = 0;
    int width = 0;  ///< Of the picture as it was measured.
    int height = 0;
    std::vector<BlockDetail> blocks;  ///< Row by row; pixels beyond the last whole block are left out.
};

/// `rgb`: 3 channels. Thread-safe.
Detail detail_of(const Raster8& rgb);

}  // namespace fresco::sharpest

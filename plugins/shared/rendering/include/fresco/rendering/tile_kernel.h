#pragma once

#include <cstddef>
#include <cstdint>

/// \file The loops that draw a tile, compiled for several kinds of processors from tile_kernel.inl. Tile::draw calls the fastest
/// one.

namespace fresco::rendering
{

/// A triangle in a picture. Coordinates are fixed-point with some number of fractional bits: pixel (i, j) has its center at (i,
/// j).
struct Piece
{
    std::int32_t x[3];
    std::int32_t y[3];
    float nearness[3];   ///< 1 / depth of the corners, per meter; above 0.
    std::uint32_t face;  ///< Number of the face in the mesh.
};

inline constexpr int tile_width = 64;
inline constexpr int tile_height = 32;
/// Distance between the rows of a tile's keys; longer than a row because vectorized loops write beyond the last column.
inline constexpr int tile_stride = tile_width + 8;

/// Pieces as wide and as high as this at most are drawn with edge functions in double precision, which hold whole numbers up to
/// 2^53: products of two differences below 2^25, and sums of two of those.
inline constexpr std::int32_t narrow_limit = 1 << 25;

/// Draws pieces into a tile for one kind of processor.
struct TileKernel
{
    const char* name;

    /// Pieces `numbers[0 … count)` of `pieces`, each of which reaches into the tile whose first pixel is (x, y). `keys`: see
    /// Tile.
    void (*draw)(const Piece* pieces, const std::uint32_t* numbers, std::size_t count, int bits, int x, int y,
                 std::uint64_t* keys);
};

/// A piece that is not narrow, in whole numbers of 64 bits.
void draw_wide(const Piece& piece, int bits, int x, int y, std::uint64_t* keys);

/// For any processor, and for x86-64 ones with AVX2 and FMA, and with AVX-512; null where the compiler cannot make them.
const TileKernel* base_kernel();
const TileKernel* avx2_kernel();
const TileKernel* avx512_kernel();
/// The fastest that this processor can run.
const TileKernel& fastest_kernel();

}  // namespace fresco::rendering

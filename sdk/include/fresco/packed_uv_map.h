#pragma once

#include <fresco/uv_maps.h>

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

/// \file The packed form of one uv map, as the store holds it: values rounded to steps, their differences to the neighbors, and
/// Zstandard. sdk/docs/uv_maps.md describes it byte by byte.

namespace fresco
{

/// Texcoords in steps of 1 / (2^bits - 1).
constexpr int min_uv_bits = 16;
constexpr int max_uv_bits = 22;

/// The bits that keep a texcoord within 0.032 texel of a square texture of so many texels a side, 16 at least: 16 up to 4096, 18
/// for 16384. Throws std::invalid_argument outside 1 … 262144.
int uv_bits_for_texture(int size_px);

/// The fewest bits whose steps hold every valid pixel's texcoord exactly, as those of an unpacked map do; max_uv_bits if none do,
/// which are within 1.5e-7. Both rasters of one size.
int uv_bits_of(const UvMap& map);

/// The packed form. Errors are at most: texcoords 0.5 / (2^uv_bits - 1), which is 0.0313 texel of 4096 for 16 bits; cosines
/// 1/510; depth 0.5 mm up to 2 km and 5e-7 of the largest beyond, and none below 0.5 mm becomes 0. Packing what was unpacked
/// gives it again. The same map gives the same bytes with the same version of Zstandard. What invalid pixels hold is not looked
/// at. Throws Error naming `source` and the first valid pixel whose texcoord or cosine is not in [0,1] (1e-5 beyond is rounding)
/// or whose depth is negative or not finite; rasters that do not fit together; std::invalid_argument for uv_bits outside 16 … 22.
/// Thread-safe.
std::vector<std::byte> pack_uv_map(const UvMap& map, int uv_bits, std::string_view source);

/// The map of a packed form. Invalid pixels are 0 in every raster. Throws Error naming `source`, the offset, what was expected
/// and what to do, if the bytes are damaged or not of this size; memory stays within the map's and its packed planes'.
/// Thread-safe.
UvMap unpack_uv_map(std::span<const std::byte> bytes, int width, int height, std::string_view source);

}  // namespace fresco

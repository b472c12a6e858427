#pragma once

#include <fresco/image.h>

#include <cstddef>
#include <span>
#include <string>

namespace sens
{

/// 16-bit values that zlib compressed (RFC 1950), width x height of them, little-endian. Throws Error naming `place` for damage
/// and for another count; never more than the picture is unpacked.
fresco::Raster16 unpack_depth(std::span<const std::byte> packed, int width, int height, const std::string& place);

}  // namespace sens

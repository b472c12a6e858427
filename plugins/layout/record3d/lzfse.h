#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace record3d
{

/// Unpacks LZFSE data (Apple's format: blocks bvx2, bvxn and bvx-, ended by bvx$) that must give exactly `size` bytes, so that no
/// size that the data claims takes memory. Throws Error naming `source` and the byte offset: data that are damaged, cut, of
/// another size, or followed by others.
std::vector<std::byte> unpack_lzfse(std::span<const std::byte> packed, std::size_t size, std::string_view source);

}  // namespace record3d

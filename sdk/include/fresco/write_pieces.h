#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace fresco
{

/// As write_file, for a file whose bytes lie in several places: `pieces`, one after the other. What is large need not be copied
/// together first.
void write_pieces(const std::filesystem::path& file, std::span<const std::span<const std::byte>> pieces);

}  // namespace fresco

#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace fresco
{

/// As write_durable_file, with the bytes of all `pieces`, one after the other: large data need not be joined in memory first.
void write_pieces(const std::filesystem::path& file, std::span<const std::span<const std::byte>> pieces);

}  // namespace fresco

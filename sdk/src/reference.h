#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace fresco::detail
{

/// The part of `path` below `base`, or nothing.
std::optional<std::string> below(const std::filesystem::path& path, const std::filesystem::path& base);

}  // namespace fresco::detail

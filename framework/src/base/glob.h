#pragma once

#include <filesystem>
#include <string_view>

/// \file Files below a folder by pattern, as options and dependencies name them.

namespace fresco::host
{

/// Whether there is a file or folder below `root` whose path relative to it matches `pattern`: '*' and '?' within one name.
bool has_entry(const std::filesystem::path& root, std::string_view pattern);

/// One name against one pattern with '*' and '?'.
bool name_matches(std::string_view name, std::string_view pattern);

}  // namespace fresco::host

#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

/// \file Files below a folder by pattern. Estimates count them; options and dependencies check them.

namespace fresco::host
{

/// Files below a folder that match a pattern.
struct GlobMeasure
{
    std::uint64_t files = 0;
    std::uint64_t bytes = 0;
    bool cut_short = false;  ///< The folder holds more than was looked at.
};

/// Counts the regular files below `root` whose path relative to it matches `pattern`: '*' and '?' within one name, "**" for any
/// folders. `root` may be a file: it is counted itself, whatever the pattern. What cannot be read is passed over; links to
/// folders are not followed. Looks at no more than 200 000 entries, 16 folders deep.
GlobMeasure measure_files(const std::filesystem::path& root, std::string_view pattern);

/// Whether there is a file or folder below `root` whose path relative to it matches `pattern`: '*' and '?' within one name.
bool has_entry(const std::filesystem::path& root, std::string_view pattern);

/// One name against one pattern with '*' and '?'.
bool name_matches(std::string_view name, std::string_view pattern);

}  // namespace fresco::host

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace fresco::host
{

/// Why a file cannot be what an option or reader wants that takes files with these extensions (".png"), by its name and by what
/// it begins and ends with: "'a.ply' is empty", "'a.ply' is not a PLY mesh: it begins with \"hello\"". Empty where nothing speaks
/// against it, for an extension without a known signature, and for a file that cannot be read. Reads a few kilobytes of a file
/// that is fine.
std::string file_problem(const std::filesystem::path& file, const std::vector<std::string>& extensions);

}  // namespace fresco::host

#pragma once

#include <fresco/run_context.h>

#include <filesystem>
#include <vector>

namespace seven_scenes
{

/// The folders `path`/seq-XX by number; of the numbers in `wanted`, where it is not empty. Throws MissingInput if there are none,
/// or not the wanted ones; Error for two of one number.
std::vector<std::filesystem::path> list_sequences(const std::filesystem::path& path, const std::vector<int>& wanted,
                                                  fresco::RunContext& run);

}  // namespace seven_scenes

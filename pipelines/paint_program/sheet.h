#pragma once

#include <filesystem>

namespace fresco::paint
{

/// Joins pictures of a sweep's results into one: for each combination the view that shows the most of the room, the same for all,
/// above its style picture and its name. `folder`: of sweep.json. Writes sheet.jpg there and returns its path; empty where no
/// combination has views. Throws Error if a file cannot be read or written.
std::filesystem::path write_sheet(const std::filesystem::path& folder);

}  // namespace fresco::paint

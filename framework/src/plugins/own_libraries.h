#pragma once

#include <filesystem>
#include <set>
#include <vector>

namespace fresco::host
{

/// Of the libraries that an open library needs, directly or not: those that belong to fresco (named libfresco_*, or lying in the
/// library's folder, the folder above it, or the installation's lib folder). Sorted. `handle` is what dlopen gave.
std::vector<std::filesystem::path> own_libraries_of(void* handle, const std::filesystem::path& library);

/// Those folders, canonical.
std::set<std::filesystem::path> own_folders(const std::filesystem::path& library);

/// The folder of the running program.
std::filesystem::path program_folder();

}  // namespace fresco::host

#pragma once

#include <fresco/recording.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace scannet
{

/// Lists `path`/color/N.jpg (or .png), depth/N.png, pose/N.txt by number (10 after 9), every `every`-th of them, from the first
/// on; their sequence is "scene". Throws MissingInput if a folder is missing or empty, or if chosen views lack one of their files
/// (the first ones are named).
std::vector<fresco::ViewFiles> list_views(const std::filesystem::path& path, int every);

/// The scene's mesh in `path`. `kind` "full": *_vh_clean.ply, "reduced": *_vh_clean_2.ply, "auto": the full one if it is there,
/// else the reduced one. Throws MissingInput if there is none, Error if there are several.
std::filesystem::path find_mesh(const std::filesystem::path& path, std::string_view kind);

/// The pattern of the names that find_mesh looks for to find `mesh`, and of those that would be taken before it.
std::vector<std::string> mesh_names(const std::filesystem::path& mesh, std::string_view kind);

/// The text file of the scene's properties, `path`/<scene>.txt: the one named like the folder, else the only .txt file. Empty if
/// there is none.
std::filesystem::path find_properties(const std::filesystem::path& path);
/// The pattern of the names that find_properties looks for to find `properties`.
std::string properties_names(const std::filesystem::path& path, const std::filesystem::path& properties);

}  // namespace scannet

#pragma once

#include <fresco/run_context.h>

#include <filesystem>
#include <string_view>

namespace scannet
{

/// The scene's mesh in `path`. `kind` "full": *_vh_clean.ply, "reduced": *_vh_clean_2.ply, "auto": the full one if it is there,
/// else the reduced one, else none: empty. Throws MissingInput if another kind is missing, Error if there are several.
std::filesystem::path find_mesh(const std::filesystem::path& path, std::string_view kind, fresco::RunContext& run);

/// The text file of the scene's properties, `path`/<scene>.txt: the one named like the folder, else the only .txt file. Empty if
/// there is none.
std::filesystem::path find_properties(const std::filesystem::path& path, fresco::RunContext& run);

}  // namespace scannet

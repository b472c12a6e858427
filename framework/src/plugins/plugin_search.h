#pragma once

#include "plugins/catalog.h"

#include <filesystem>
#include <string>
#include <vector>

/// \file Finds the plugins, and remembers what they declared, so that commands answer at once.

namespace fresco::host
{

/// Where plugins are looked for, in this order: $FRESCO_PLUGIN_PATH (folders separated by ':'), the user's folder
/// ($XDG_DATA_HOME/fresco/plugins or ~/.local/share/fresco/plugins), the installation (lib/fresco beside the program's bin). What
/// is found in one shadows what later ones have of the same type, so that a plugin can be rebuilt beside its installation.
struct PluginFolder
{
    std::filesystem::path path;
    std::string origin;  ///< "FRESCO_PLUGIN_PATH", "user", "installation".
};
std::vector<PluginFolder> plugin_folders();
/// What a run should say of them: everybody may put plugins into one, or one of FRESCO_PLUGIN_PATH cannot be listed.
std::vector<std::string> plugin_folder_warnings();

/// The folder of remembered plugin descriptions: `fresco/descriptors` in $XDG_CACHE_HOME or ~/.cache; empty where neither
/// variable nor home is set.
std::filesystem::path descriptor_cache_folder();

/// Everything in the plugin folders: descriptions from the cache where the file is known (by stamp, then by contents), from a
/// child process otherwise. Opens no library in this process. `again`: ask refused libraries again.
Catalog load_catalog(bool again = false);

/// One hash for a plugin's own bytes and those of fresco's libraries that it runs with.
std::string combined_library_hash(const std::string& plugin_hash, const std::vector<std::string>& own_hashes);

}  // namespace fresco::host

#pragma once

#include "plugins/catalog.h"

#include <filesystem>
#include <string>
#include <vector>

/// \file Finds the plugins.

namespace fresco::host
{

/// fresco looks for plugins in this order: $FRESCO_PLUGIN_PATH (folders separated by ':'), the user's folder
/// ($XDG_DATA_HOME/fresco/plugins or ~/.local/share/fresco/plugins), the installation (lib/fresco beside the program's bin). What
/// is found in one shadows what later ones have of the same type, so that a plugin can be rebuilt beside its installation.
struct PluginFolder
{
    std::filesystem::path path;
    std::string origin;  ///< "FRESCO_PLUGIN_PATH", "user", "installation".
};
std::vector<PluginFolder> plugin_folders();
/// Warns where everybody may put plugins into a folder, or one of FRESCO_PLUGIN_PATH cannot be listed.
std::vector<std::string> plugin_folder_warnings();

/// All that the descriptions in the plugin folders say. Opens no library.
Catalog load_catalog();

}  // namespace fresco::host

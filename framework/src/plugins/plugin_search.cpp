#include "plugins/plugin_search.h"
#include "base/common.h"
#include "base/process.h"
#include "base/text.h"
#include "plugins/plugin_library.h"
#include <fresco/error.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <utility>

namespace fresco::host
{
namespace
{

constexpr const char* named_by_user = "FRESCO_PLUGIN_PATH";

/// Plugins are NAME.so; libNAME.so beside them is a library that they link, such as an artifact type of their own.
bool is_named_as_plugin(const fs::path& file)
{
    return file.extension() == ".so" && !file.filename().string().starts_with("lib");
}

/// The files of all folders that look like plugins, each once, behind the place of its folder: all folders of FRESCO_PLUGIN_PATH
/// are one.
std::set<std::pair<std::size_t, fs::path>> candidates()
{
    std::set<std::pair<std::size_t, fs::path>> files;
    std::set<fs::path> known;
    std::set<std::string> origins;
    for (const auto& folder : plugin_folders())
    {
        origins.insert(folder.origin);
        const std::size_t place = origins.size();
        std::error_code error, unresolved;
        for (fs::directory_iterator entry(folder.path, error); !error && entry != fs::directory_iterator();
             entry.increment(error))
            if (is_named_as_plugin(entry->path()))
                if (const auto [file, fresh] = known.insert(fs::weakly_canonical(entry->path(), unresolved)); fresh)
                    files.emplace(place, *file);
    }
    return files;
}

/// The plugins of fresco's own tree that are not in `folder`, by the list that the build puts there: a line for each, NAME where
/// it was to be built and NAME: REASON where it was left out. The type of mesh_decimate is mesh.decimate.
void add_unbuilt(Catalog& catalog, const fs::path& folder)
{
    std::ifstream list(folder / "plugins.txt");
    for (std::string line; std::getline(list, line);)
    {
        const std::size_t colon = std::min(line.find(": "), line.size());
        std::string type = line.substr(0, colon);
        std::error_code error;
        if (type.empty() || fs::exists(folder / (type + ".so"), error))
            continue;
        if (const std::size_t separator = type.find('_'); separator != std::string::npos)
            type[separator] = '.';
        if (catalog.libraries_of(type).empty() && !catalog.find_unbuilt(type))
            catalog.add(UnbuiltPlugin{type, colon < line.size() ? line.substr(colon + 2) : ""});
    }
}

}  // namespace

std::vector<PluginFolder> plugin_folders()
{
    std::vector<PluginFolder> folders;
    if (const char* path = std::getenv(named_by_user))
        for (const std::string& folder : split(path, ':'))
            if (!folder.empty())
                folders.push_back({fs::absolute(folder), named_by_user});
    const auto is_absolute = [](const char* folder) { return folder != nullptr && *folder == '/'; };
    if (const char* data = std::getenv("XDG_DATA_HOME"); is_absolute(data))
        folders.push_back({fs::path(data) / "fresco/plugins", "user"});
    else if (const char* home = std::getenv("HOME"); is_absolute(home))
        folders.push_back({fs::path(home) / ".local/share/fresco/plugins", "user"});
    if (const fs::path program = own_program(); !program.empty())
        folders.push_back({program.parent_path().parent_path() / "lib" / "fresco", "installation"});
    return folders;
}

std::vector<std::string> plugin_folder_warnings()
{
    std::vector<std::string> warnings;
    for (const PluginFolder& folder : plugin_folders())
    {
        std::error_code error;
        const fs::directory_iterator entries(folder.path, error);
        const auto is_plugin = [](const fs::directory_entry& entry) { return is_named_as_plugin(entry.path()); };
        const bool is_empty = !error && std::ranges::none_of(entries, is_plugin);
        if (folder.origin == named_by_user && (error || is_empty))
            warnings.push_back("FRESCO_PLUGIN_PATH: " + folder.path.string() + ": " +
                               (error ? error.message() : "holds no plugin (NAME.so)"));
        if (!error && (fs::status(folder.path, error).permissions() & fs::perms::others_write) != fs::perms::none)
            warnings.push_back(folder.path.string() +
                               ": every user may put plugins into this folder, and they run as you: chmod o-w " +
                               shell_word(folder.path.string()));
    }
    return warnings;
}

Catalog load_catalog()
{
    Catalog catalog;
    for (const auto& [place, file] : candidates())
    {
        try
        {
            PluginDescription plugin = read_description(file);
            const auto bytes = std::make_shared<PluginBytes>(std::move(plugin.files));
            for (TypeDescription& type : plugin.types)
            {
                type.library = file;
                type.bytes = bytes;
                type.library_versions = plugin.versions;
                type.place = place;
                catalog.add(std::move(type));
            }
        }
        catch (const Error& error)
        {
            catalog.add(Refusal{file, error.what()});
        }
    }
    for (const auto& folder : plugin_folders())
        add_unbuilt(catalog, folder.path);
    return catalog;
}

}  // namespace fresco::host

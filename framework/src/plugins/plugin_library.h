#pragma once

#include "plugins/catalog.h"
#include <fresco/plugin_library.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

/// \file One plugin: its description, which the host reads, and its library, which only processes of their own open: workers, and
/// one that tries all that a run needs before it begins.

namespace fresco::host
{

/// NAME.json, as fresco-describe wrote it beside NAME.so.
struct PluginDescription
{
    std::vector<std::filesystem::path> files;  ///< The library, then fresco's own libraries that it runs with.
    Value versions;                            ///< Map name -> version of the other libraries behind it.
    std::vector<TypeDescription> types;        ///< Without what the files say.
};

/// Throws Error, without the library's name, if there is no description, it belongs to another build of the library, or it says
/// that the plugin was built for another fresco.
PluginDescription read_description(const std::filesystem::path& library);

struct OpenPlugin
{
    const PluginLibrary* library = nullptr;
    PluginBytes bytes;
};
/// Opens a plugin in this process. Throws Error as read_description and PluginLibrary::open do, and where the loader chose
/// another of fresco's own libraries than the description leads to: the keys of results would not name it.
OpenPlugin open_plugin(const std::filesystem::path& library);

/// Opens all in a worker and returns those that cannot be opened, with the reason, each alone too. After one that crashes or
/// hangs, another worker opens the rest.
std::vector<Refusal> refused_when_opened(const std::set<std::filesystem::path>& libraries);
/// Opens all plugins of the catalog, and adds to its refusals those that cannot be opened.
void open_all(Catalog& catalog);
/// The worker: sends a line for each library, the reason or an empty one. Does not return.
[[noreturn]] void internal_open(const std::vector<std::string>& libraries);

}  // namespace fresco::host

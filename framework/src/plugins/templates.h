#pragma once

#include <string>
#include <vector>

namespace fresco::host
{

struct TextFile
{
    std::string path;  ///< Below the folder that is to be made: "tests/test_my_dots.cpp".
    std::string text;
};

/// Files of the folder `sdk/templates/NAME`, which are built into this program, as they are. Empty: no such folder.
std::vector<TextFile> template_files(const std::string& name);

/// What `fresco new` can begin: the folders of sdk/templates that hold a plugin, sorted.
std::vector<std::string> plugin_kinds();

/// The folder of the plugin `type` ("my.dots"): "my_dots".
std::string plugin_folder_name(const std::string& type);

/// A plugin of one of plugin_kinds() that holds `type`: sources, tests, CMakeLists.txt, README.md and a pipeline that uses it.
/// Throws Error if `type` is not a valid type name (small letters, digits and _, with a dot between), or no name in C++ comes of
/// it.
std::vector<TextFile> new_plugin(const std::string& kind, const std::string& type);

}  // namespace fresco::host

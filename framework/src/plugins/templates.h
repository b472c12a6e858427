#pragma once

#include <string>
#include <vector>

/// \file What `fresco new` and `fresco init` write: files of sdk/templates, which are built into the program.

namespace fresco::host
{

/// A file below sdk/templates.
struct BuiltInText
{
    const char* folder;
    const char* path;
    const char* text;
};
extern const std::vector<BuiltInText> built_in_texts;

struct TextFile
{
    std::string path;  ///< Below the folder that is to be made: "tests/test_my_dots.cpp".
    std::string text;
};

/// Files of the folder `sdk/templates/NAME`, which are built into this program, as they are. Empty: no such folder.
std::vector<TextFile> template_files(const std::string& name);

/// Kinds of plugins for `fresco new`: the folders of sdk/templates that hold a plugin, sorted.
std::vector<std::string> plugin_kinds();

/// The folder of the plugin `type` ("my.dots"): "my_dots".
std::string plugin_folder_name(const std::string& type);

/// A plugin of one of plugin_kinds() that holds `type`: sources, tests, CMakeLists.txt, README.md and a pipeline that uses it.
/// Throws Error if `type` is not a valid type name (small letters, digits and _, with a dot between), or no name in C++ comes of
/// it.
std::vector<TextFile> new_plugin(const std::string& kind, const std::string& type);

}  // namespace fresco::host

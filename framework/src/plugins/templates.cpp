#include "plugins/templates.h"
#include "plugins/plugin_library.h"
#include <fresco/error.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string_view>
#include <utility>

namespace fresco::host
{

namespace
{

using Names = std::array<std::pair<std::string_view, std::string>, 3>;

/// In one pass: a name that is put in is not looked at again.
void replace_all(std::string& text, const Names& names)
{
    for (std::size_t at = 0; at < text.size();)
    {
        const auto name = std::find_if(names.begin(), names.end(),
                                       [&](const auto& each) { return text.compare(at, each.first.size(), each.first) == 0; });
        if (name == names.end())
        {
            ++at;
            continue;
        }
        text.replace(at, name->first.size(), name->second);
        at += name->second.size();
    }
}

/// "my.dark_dots" -> "MyDarkDots"
std::string class_name(std::string_view type)
{
    std::string name;
    bool begins = true;
    for (const char c : type)
    {
        if (c != '.' && c != '_')
            name += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
        begins = c == '.' || c == '_';
    }
    return name;
}

}  // namespace

std::vector<TextFile> template_files(const std::string& name)
{
    std::vector<TextFile> files;
    for (const auto& [folder, path, text] : built_in_texts)
        if (name == folder)
            files.push_back({path, text});
    return files;
}

std::vector<std::string> plugin_kinds()
{
    std::set<std::string> kinds;
    for (const auto& [folder, path, text] : built_in_texts)
        if (std::string_view(path) == "CMakeLists.txt")
            kinds.insert(folder);
    return {kinds.begin(), kinds.end()};
}

std::string plugin_folder_name(const std::string& type)
{
    std::string name = type;
    std::replace(name.begin(), name.end(), '.', '_');
    return name;
}

std::vector<TextFile> new_plugin(const std::string& kind, const std::string& type)
{
    // The folder, files and namespace are named after it.
    const auto are_separators = [](char a, char b) { return (a == '.' || a == '_') && (b == '.' || b == '_'); };
    if (!is_type_name(type) || type.find('.') == std::string::npos || type.front() < 'a' ||
        std::ranges::adjacent_find(type, are_separators) != type.end())
        throw Error("invalid type name '" + type +
                    "': use lowercase letters and digits, with a dot and '_' between, such as my." + kind);
    auto files = template_files(kind);
    files.push_back({".gitignore", "build/\n.fresco/\nout/\n"});
    const Names names{{{"my.plugin", type}, {"my_plugin", plugin_folder_name(type)}, {"MyPlugin", class_name(type)}}};
    for (auto& file : files)
        for (std::string* text : {&file.path, &file.text})
            replace_all(*text, names);
    return files;
}

}  // namespace fresco::host

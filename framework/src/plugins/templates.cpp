#include "plugins/templates.h"
#include "plugins/plugin_library.h"
#include <fresco/error.h>

#include <algorithm>
#include <boost/algorithm/string.hpp>
#include <cctype>
#include <set>
#include <string_view>
#include <utility>

namespace fresco::host
{

namespace
{

/// "my.dark_dots" -> "MyDarkDots"
std::string class_name(const std::string& type)
{
    std::vector<std::string> words;
    boost::split(words, type, boost::is_any_of("._"));
    for (std::string& word : words)
        word.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(word.front())));
    return boost::join(words, "");
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
    return boost::replace_all_copy(type, ".", "_");
}

std::vector<TextFile> new_plugin(const std::string& kind, const std::string& type)
{
    // The folder, files and namespace are named after it.
    const auto are_separators = [](char a, char b) { return (a == '.' || a == '_') && (b == '.' || b == '_'); };
    if (!is_type_name(type) || type.find('.') == std::string::npos || type.front() < 'a' || type.back() == '_' ||
        std::ranges::adjacent_find(type, are_separators) != type.end())
        throw Error("invalid type name '" + type +
                    "': use lowercase letters and digits, with a dot and '_' between, such as my." + kind);
    auto files = template_files(kind);
    files.push_back({".gitignore", "build/\n.fresco/\nout/\n"});
    // In this order no name that was put in holds one that is still to be replaced.
    for (const auto& [name, own] :
         {std::pair("MyPlugin", class_name(type)), {"my_plugin", plugin_folder_name(type)}, {"my.plugin", type}})
        for (auto& file : files)
        {
            boost::replace_all(file.path, name, own);
            boost::replace_all(file.text, name, own);
        }
    return files;
}

}  // namespace fresco::host

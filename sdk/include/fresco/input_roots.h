#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace fresco
{

/// Folders of the user's files by the names that a pipeline gives them under `inputs:`. What lies below one is stored by its name
/// and the rest of its path, so that a result means the same wherever the folder is mounted.
using InputRoots = std::map<std::string, std::filesystem::path>;

/// The roots of this process, absolute. The host sets them before anything reads them.
void set_input_roots(InputRoots roots);
const InputRoots& input_roots();

/// "input:NAME/rest" for a file or folder below a root, of several the innermost; otherwise the path itself.
std::string input_name(const std::filesystem::path& file);
bool is_input_name(std::string_view text);
/// The file that input_name gave this name. The text itself where it is a path, or names a root that this process does not have.
std::filesystem::path input_path(const std::string& name);

}  // namespace fresco

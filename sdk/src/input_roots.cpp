#include "reference.h"

#include <fresco/input_roots.h>

namespace fresco
{
namespace
{

namespace fs = std::filesystem;

constexpr std::string_view prefix = "input:";

InputRoots& roots_of_process()
{
    static InputRoots roots;
    return roots;
}

}  // namespace

void set_input_roots(InputRoots roots)
{
    roots_of_process() = std::move(roots);
}

const InputRoots& input_roots()
{
    return roots_of_process();
}

std::string input_name(const fs::path& file)
{
    std::string name = file.string();
    std::size_t longest = 0;
    for (const auto& [root, folder] : input_roots())
    {
        const auto rest = detail::below(file, folder);
        const std::size_t length = folder.string().size();
        if ((!rest && file != folder) || length <= longest)
            continue;
        longest = length;
        name = std::string(prefix) + root + (rest ? "/" + *rest : "");
    }
    return name;
}

bool is_input_name(std::string_view text)
{
    return text.starts_with(prefix);
}

fs::path input_path(const std::string& name)
{
    if (!is_input_name(name))
        return name;
    const std::size_t slash = name.find('/');
    const auto root = input_roots().find(name.substr(prefix.size(), slash == std::string::npos ? slash : slash - prefix.size()));
    if (root == input_roots().end())
        return name;
    return slash == std::string::npos ? root->second : root->second / name.substr(slash + 1);
}

}  // namespace fresco

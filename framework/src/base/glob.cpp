#include "base/glob.h"
#include "base/common.h"

#include <system_error>

namespace fresco::host
{

bool name_matches(std::string_view name, std::string_view pattern)
{
    std::size_t n = 0;
    std::size_t p = 0;
    std::size_t star = std::string_view::npos;
    std::size_t after_star = 0;
    while (n < name.size())
    {
        if (p < pattern.size() && pattern[p] == '*')
        {
            star = p++;
            after_star = n;
        }
        else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n]))
        {
            ++p;
            ++n;
        }
        else if (star != std::string_view::npos)
        {
            // The last star takes one character more; an earlier one never has to.
            p = star + 1;
            n = ++after_star;
        }
        else
            return false;
    }
    while (p < pattern.size() && pattern[p] == '*')
        ++p;
    return p == pattern.size();
}

bool has_entry(const fs::path& root, std::string_view pattern)
{
    const std::size_t slash = pattern.find('/');
    const std::string_view name = pattern.substr(0, slash);
    const auto rest_in = [&](const fs::path& entry)
    { return slash == std::string_view::npos || has_entry(entry, pattern.substr(slash + 1)); };
    std::error_code failure;
    if (name.find_first_of("*?") == std::string_view::npos)
        return fs::exists(root / name, failure) && rest_in(root / name);
    fs::directory_iterator entry(root, failure);
    for (; !failure && entry != fs::directory_iterator(); entry.increment(failure))
        if (name_matches(entry->path().filename().string(), name) && rest_in(entry->path()))
            return true;
    return false;
}

}  // namespace fresco::host

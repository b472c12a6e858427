#include "base/glob.h"
#include "base/common.h"

#include <boost/algorithm/string/replace.hpp>
#include <fnmatch.h>
#include <system_error>

namespace fresco::host
{

bool name_matches(std::string_view name, std::string_view pattern)
{
    // A bracket is a character as others are.
    const std::string words = boost::replace_all_copy(std::string(pattern), "[", "[[]");
    return fnmatch(words.c_str(), std::string(name).c_str(), FNM_NOESCAPE) == 0;
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

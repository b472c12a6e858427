#pragma once

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <vector>

/// \file Names of the parts of an artifact, for rules (RuleForm). A part may lie in others: "furniture/part_2" lies in
/// "furniture".

namespace fresco
{

/// The names of a path, the innermost first: "a/b/c" gives c, b, a.
inline std::vector<std::string> names_in_path(std::string_view path)
{
    std::vector<std::string> names;
    for (auto slash = path.rfind('/'); slash != std::string_view::npos; slash = path.rfind('/'))
    {
        names.emplace_back(path.substr(slash + 1));
        path = path.substr(0, slash);
    }
    names.emplace_back(path);
    return names;
}

/// All names that rules may give to these parts, each once: the names in their paths, then the paths.
inline std::vector<std::string> names_for_rules(const std::vector<std::string>& parts)
{
    std::vector<std::string> names;
    std::set<std::string> known;
    const auto add = [&](const std::string& name)
    {
        if (!name.empty() && known.insert(name).second)
            names.push_back(name);
    };
    for (const std::string& part : parts)
    {
        const std::vector<std::string> inner = names_in_path(part);
        std::for_each(inner.rbegin(), inner.rend(), add);
    }
    std::ranges::for_each(parts, add);
    return names;
}

}  // namespace fresco

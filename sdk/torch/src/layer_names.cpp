#include <fresco/torch/features.h>

#include <algorithm>

namespace fresco
{

std::vector<std::string> split_layer_names(std::string_view list)
{
    constexpr std::string_view separators = ", \t\n";
    std::vector<std::string> names;
    while (true)
    {
        const auto begin = list.find_first_not_of(separators);
        if (begin == std::string_view::npos)
            return names;
        const auto end = std::min(list.find_first_of(separators, begin), list.size());
        std::string name(list.substr(begin, end - begin));
        if (std::find(names.begin(), names.end(), name) == names.end())
            names.push_back(std::move(name));
        list.remove_prefix(end);
    }
}

}  // namespace fresco

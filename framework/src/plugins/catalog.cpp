#include "plugins/catalog.h"

#include <algorithm>

namespace fresco::host
{

void Catalog::add(TypeDescription description)
{
    std::vector<TypeDescription>& same = types_[description.type];
    same.push_back(std::move(description));
}

void Catalog::add(Refusal refusal)
{
    refusals_.push_back(std::move(refusal));
}

void Catalog::add(UnbuiltPlugin plugin)
{
    unbuilt_.push_back(std::move(plugin));
}

const UnbuiltPlugin* Catalog::find_unbuilt(std::string_view type) const
{
    const auto found = std::find_if(unbuilt_.begin(), unbuilt_.end(), [&](const auto& plugin) { return plugin.type == type; });
    return found != unbuilt_.end() ? &*found : nullptr;
}

const TypeDescription* Catalog::find(std::string_view type) const
{
    const auto found = types_.find(type);
    return found != types_.end() && found->second.size() == 1 ? &found->second.front() : nullptr;
}

std::vector<const TypeDescription*> Catalog::types() const
{
    std::vector<const TypeDescription*> result;
    for (const auto& [name, descriptions] : types_)
        if (descriptions.size() == 1)
            result.push_back(&descriptions.front());
    return result;
}

std::vector<std::string> Catalog::ambiguous() const
{
    std::vector<std::string> names;
    for (const auto& [name, descriptions] : types_)
        if (descriptions.size() > 1)
            names.push_back(name);
    return names;
}

std::vector<std::filesystem::path> Catalog::libraries_of(std::string_view type) const
{
    std::vector<std::filesystem::path> libraries;
    if (const auto found = types_.find(type); found != types_.end())
        for (const TypeDescription& description : found->second)
            libraries.push_back(description.library);
    return libraries;
}

}  // namespace fresco::host

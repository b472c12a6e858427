#include <fresco/strict_map.h>

#include <fresco/error.h>

namespace fresco
{

const Value& StrictMap::take(std::string_view key)
{
    const Value* value = map_.is_map() ? map_.find(key) : nullptr;
    if (value == nullptr)
        throw Error("the entry \"" + std::string(key) + "\" is missing");
    taken_.emplace(key);
    return *value;
}

void StrictMap::refuse_others() const
{
    for (const auto& [key, value] : map_.as_map())
        if (!taken_.contains(key))
            throw Error("the entry \"" + key + "\" is not known");
}

}  // namespace fresco

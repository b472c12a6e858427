#pragma once

#include <fresco/value.h>

#include <set>
#include <string>
#include <string_view>

namespace fresco
{

/// Reads a map of known entries, each taken once; for the documented forms that fresco reads back. What is not as expected is an
/// Error that names the entry; the caller adds the file. References the map, which must outlive it.
class StrictMap
{
  public:
    explicit StrictMap(const Value& map) : map_(map) {}

    /// Throws Error if the entry is missing, or if the value is no map.
    const Value& take(std::string_view key);
    /// Throws Error if the map has an entry that was not taken.
    void refuse_others() const;

  private:
    const Value& map_;
    std::set<std::string, std::less<>> taken_;
};

}  // namespace fresco

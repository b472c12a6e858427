#pragma once

#include <fresco/camera.h>
#include <fresco/value.h>

#include <set>
#include <string>
#include <string_view>

/// \file Pieces of the manifest, read strictly. What is not as expected is an Error that names the entry; the caller adds the
/// file.

namespace fresco::dataset::detail
{

/// The entries of a map, each to be taken once. References the map.
class Entries
{
  public:
    explicit Entries(const Value& map) : map_(map) {}
    const Value& take(std::string_view key);
    /// Throws Error if the map has an entry that was not taken.
    void refuse_others() const;

  private:
    const Value& map_;
    std::set<std::string, std::less<>> taken_;
};

/// {width, height, fx, fy, cx, cy, world_from_camera: three rows of four}
Value camera_value(const Camera& camera);
Camera camera_from(const Value& value, const std::string& name);

/// The same text, checked to be usable as one part of a path.
std::string checked_part(const std::string& text, const std::string& entry);
/// The same name, checked to lead to a file below the folder it is relative to.
std::string checked_name(const std::string& name);

}  // namespace fresco::dataset::detail

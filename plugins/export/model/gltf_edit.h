#pragma once

#include <fresco/gltf/gltf_file.h>
#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file Edits the JSON of a glTF file together with its buffers, and writes it as a GLB.

namespace export_model
{

using fresco::Value;

/// The list of a document, made if it is not there.
Value::List& list_of(Value& document, std::string_view key);
void remove(Value& map, std::string_view key);
/// The entry of an extension, or null.
using fresco::gltf::extension_of;
Value* extension_of(Value& map, std::string_view name);
void remove_extension(Value& map, std::string_view name);
std::size_t size_or(const Value& map, std::string_view key, std::size_t otherwise);
/// Removes the entries of a list whose numbers are in `gone`. Returns the new number of each.
std::vector<std::int64_t> removed(Value::List& list, const std::set<std::int64_t>& gone);

template <class Visit>
void visit_entries(Value& value, const Visit& visit);

template <class Visit>
void visit_entries(Value::List& values, const Visit& visit)
{
    for (Value& each : values)
        visit_entries(each, visit);
}

/// Calls `visit(key, value)` for all entries of maps at any depth but extras.
template <class Visit>
void visit_entries(Value& value, const Visit& visit)
{
    if (value.is_list())
        visit_entries(value.as_list(), visit);
    else if (value.is_map())
        for (auto& [key, inner] : value.as_map())
            if (key != "extras")
            {
                visit(key, inner);
                visit_entries(inner, visit);
            }
}

/// A file that is being changed. New data are buffers of their own until the file is packed.
class GltfEdit
{
  protected:
    static constexpr int array_buffer = 34962;

    explicit GltfEdit(fresco::gltf::GltfFile file) : file_(std::move(file)), document_(file_.document) {}

    /// Adds a view of new bytes. Throws Error for none, and beyond the 4 GiB of a GLB.
    std::size_t add_view(std::span<const std::byte> bytes, int target = 0, std::size_t stride = 0);
    /// Puts an accessor in the place of one that nothing else uses (accessor_uses_), or at the end. Returns its number.
    std::int64_t set_accessor(std::int64_t old, Value accessor);
    std::int64_t add_floats(const std::vector<float>& values, std::size_t rows, const char* type);
    /// The rows of an accessor in another order, as they are. Throws Error unless it has a row for each of `vertices`.
    std::int64_t gathered(std::int64_t accessor, std::size_t vertices, const std::vector<std::uint32_t>& source);
    void remove_unused_views();
    /// The GLB: the bytes of views one after the other in one buffer. Buffers without bytes, which compressed views name, stay.
    /// Throws Error for a view that does not fit its buffer.
    std::string packed();

    fresco::gltf::GltfFile file_;
    Value& document_;
    std::map<std::int64_t, std::int64_t> accessor_uses_;

  private:
    std::size_t added_bytes_ = 0;
};

}  // namespace export_model

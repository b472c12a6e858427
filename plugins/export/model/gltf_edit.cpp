#include "gltf_edit.h"

#include <fresco/error.h>
#include <fresco/texturing/glb.h>

#include <fmt/format.h>

#include <cstring>
#include <limits>
#include <tuple>
#include <utility>

namespace export_model
{

using fresco::Error;
using fresco::gltf::accessor_rows;
using fresco::gltf::AccessorRows;
using fresco::gltf::entry;

namespace
{

constexpr std::size_t most_bytes = std::numeric_limits<std::uint32_t>::max();

}  // namespace

Value::List& list_of(Value& document, std::string_view key)
{
    if (document.find(key) == nullptr)
        document.set(key, Value::List{});
    return document.find(key)->as_list();
}

void remove(Value& map, std::string_view key)
{
    std::erase_if(map.as_map(), [&](const Value::Entry& each) { return each.first == key; });
}

Value* extension_of(Value& map, std::string_view name)
{
    return const_cast<Value*>(extension_of(std::as_const(map), name));
}

void remove_extension(Value& map, std::string_view name)
{
    Value* const extensions = map.find("extensions");
    if (extensions == nullptr)
        return;
    remove(*extensions, name);
    if (extensions->as_map().empty())
        remove(map, "extensions");
}

std::size_t size_or(const Value& map, std::string_view key, std::size_t otherwise)
{
    const Value* const found = map.find(key);
    return found == nullptr ? otherwise : static_cast<std::size_t>(found->as_int());
}

std::vector<std::int64_t> removed(Value::List& list, const std::set<std::int64_t>& gone)
{
    std::vector<std::int64_t> numbers;
    Value::List kept;
    for (std::size_t i = 0; i < list.size(); ++i)
    {
        numbers.push_back(static_cast<std::int64_t>(kept.size()));
        if (!gone.contains(static_cast<std::int64_t>(i)))
            kept.push_back(std::move(list[i]));
    }
    list = std::move(kept);
    return numbers;
}

std::int64_t GltfEdit::gathered(std::int64_t accessor, std::size_t vertices, const std::vector<std::uint32_t>& source)
{
    const auto number = static_cast<std::size_t>(accessor);
    Value moved = list_of(document_, "accessors").at(number);
    if (size_or(moved, "count", 0) != vertices)
        throw Error(fmt::format("{}{} rows; expected one for each of {} vertices", entry("accessors", number),
                                size_or(moved, "count", 0), vertices));
    moved.set("count", source.size());
    const bool is_new = number >= file_.model.accessors.size();
    // The format has zeros in an accessor without data.
    if (is_new || file_.model.accessors[number].bufferView >= 0 || moved.find("sparse") != nullptr)
    {
        AccessorRows rows;
        // These are the white colors.
        if (is_new)
        {
            const auto view = size_or(moved, "bufferView", 0);
            const auto& bytes = file_.model.buffers.at(size_or(list_of(document_, "bufferViews")[view], "buffer", 0)).data;
            rows.first = bytes.data();
            rows.stride = 4 * sizeof(float);
            rows.components = 4;
            rows.component_type = TINYGLTF_COMPONENT_TYPE_FLOAT;
        }
        else
            rows = accessor_rows(file_.model, static_cast<int>(accessor), 1, 16);
        const std::size_t packed =
            rows.components *
            static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(rows.component_type)));
        const std::size_t stride = (packed + 3) / 4 * 4;
        std::vector<unsigned char> bytes(stride * source.size(), 0);
        for (std::size_t i = 0; i < source.size(); ++i)
            std::memcpy(&bytes[i * stride], rows.first + source[i] * rows.stride, packed);
        remove(moved, "byteOffset");
        remove(moved, "sparse");
        moved.set("bufferView", add_view(std::as_bytes(std::span(bytes)), array_buffer, stride));
    }
    return set_accessor(accessor, std::move(moved));
}

std::int64_t GltfEdit::set_accessor(std::int64_t old, Value accessor)
{
    Value::List& accessors = list_of(document_, "accessors");
    if (old >= 0 && --accessor_uses_[old] == 0)
    {
        accessors[static_cast<std::size_t>(old)] = std::move(accessor);
        return old;
    }
    accessors.push_back(std::move(accessor));
    return static_cast<std::int64_t>(accessors.size() - 1);
}

std::int64_t GltfEdit::add_floats(const std::vector<float>& values, std::size_t rows, const char* type)
{
    return set_accessor(-1, Value::Map{{"bufferView", add_view(std::as_bytes(std::span(values)), array_buffer)},
                                       {"componentType", TINYGLTF_COMPONENT_TYPE_FLOAT},
                                       {"count", rows},
                                       {"type", type}});
}

std::size_t GltfEdit::add_view(std::span<const std::byte> bytes, int target, std::size_t stride)
{
    added_bytes_ += bytes.size();
    if (bytes.empty() || added_bytes_ > most_bytes)
        throw Error(bytes.empty() ? "a picture has no bytes" : "the painted model takes more than the 4096 MiB of a GLB file");
    Value view = Value::Map{{"buffer", file_.model.buffers.size()}, {"byteLength", bytes.size()}};
    if (stride != 0)
        view.set("byteStride", stride);
    if (target != 0)
        view.set("target", target);
    const auto* const begin = reinterpret_cast<const unsigned char*>(bytes.data());
    file_.model.buffers.emplace_back().data.assign(begin, begin + bytes.size());
    Value::List& views = list_of(document_, "bufferViews");
    views.push_back(std::move(view));
    return views.size() - 1;
}

void GltfEdit::remove_unused_views()
{
    Value::List& views = list_of(document_, "bufferViews");
    std::set<std::int64_t> gone;
    for (std::size_t i = 0; i < views.size(); ++i)
        gone.insert(static_cast<std::int64_t>(i));
    const auto visit_views = [&](const auto& visit)
    {
        visit_entries(document_,
                      [&](const std::string& key, Value& value)
                      {
                          if (key == "bufferView")
                              visit(value);
                      });
    };
    visit_views([&](const Value& view) { gone.erase(view.as_int()); });
    const auto numbers = removed(views, gone);
    visit_views([&](Value& view) { view = numbers.at(static_cast<std::size_t>(view.as_int())); });
}

std::string GltfEdit::packed()
{
    std::string binary;
    std::map<std::tuple<std::size_t, std::size_t, std::size_t>, std::size_t> places;
    Value::List buffers{Value::Map{}};
    std::map<std::size_t, std::size_t> empty_buffers;
    const auto move = [&](Value& view)
    {
        const std::size_t buffer = size_or(view, "buffer", 0);
        const std::size_t offset = size_or(view, "byteOffset", 0);
        const std::size_t length = size_or(view, "byteLength", 0);
        const auto& bytes = file_.model.buffers.at(buffer).data;
        if (bytes.empty())
        {
            const auto [found, is_new] = empty_buffers.try_emplace(buffer, buffers.size());
            if (is_new)
                buffers.push_back(list_of(document_, "buffers").at(buffer));
            view.set("buffer", found->second);
            return;
        }
        if (offset > bytes.size() || length > bytes.size() - offset || length > most_bytes - binary.size())
            throw Error(fmt::format("bufferViews: {} bytes at {} do not fit into their buffer of {}, or into a GLB file", length,
                                    offset, bytes.size()));
        const auto [found, is_new] = places.try_emplace({buffer, offset, length}, binary.size());
        if (is_new)
        {
            binary.append(reinterpret_cast<const char*>(bytes.data()) + offset, length);
            binary.resize((binary.size() + 3) / 4 * 4);
        }
        view.set("buffer", 0);
        view.set("byteOffset", found->second);
    };
    for (Value& view : list_of(document_, "bufferViews"))
    {
        // A compressed view names the place of its stream.
        if (Value* const extensions = view.find("extensions"))
            for (auto& [name, extension] : extensions->as_map())
                if (extension.find("buffer") != nullptr)
                    move(extension);
        move(view);
    }
    buffers[0] = Value::Map{{"byteLength", binary.size()}};
    document_.set("buffers", std::move(buffers));
    for (const char* const list : {"extensionsUsed", "extensionsRequired", "animations", "skins"})
        if (const Value* const found = document_.find(list); found != nullptr && found->as_list().empty())
            remove(document_, list);
    return fresco::texturing::glb_of(document_, binary);
}

}  // namespace export_model

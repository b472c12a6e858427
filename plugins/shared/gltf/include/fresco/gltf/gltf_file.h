#pragma once

#include <fresco/option_declaration.h>
#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tiny_gltf.h>
#include <vector>

namespace fresco::gltf
{

FileFormat glb_format();
FileFormat gltf_format();

/// A picture of a glTF file: a view or a URI.
struct GltfImage
{
    int buffer_view = -1;
    std::string uri;  ///< As in the file, also a "data:" URI.
};

/// Contents of a glTF or GLB file. Every buffer view lies inside of its buffer; indices are not negative.
struct GltfFile
{
    tinygltf::Model model;  ///< Without images, skins, animations, cameras and extras.
    std::vector<GltfImage> images;
    Value document;  ///< The file's JSON as a whole.
};

/// Reads a buffer beside the file. `uri` is as in the file; `place` ("buffers[0]: ") begins messages.
using ReadBuffer = std::function<std::vector<std::byte>(const std::string& uri, const std::string& place)>;

/// Reads a file with tinygltf, once its JSON has been parsed strictly (at most 64 levels, no key twice), its numbers have been
/// checked, and all that is not used has been dropped. tinygltf opens no file and sees neither buffers nor pictures. What is
/// compressed (compression.h) is unpacked into buffers of its own. Throws Error naming the offset or the entry: anything but glTF
/// 2, an extension that is required and unknown, counts, types and ranges that are wrong. Does not name the file.
GltfFile load_gltf(std::span<const std::byte> file, const ReadBuffer& read_beside);

/// The bytes of a view.
std::span<const unsigned char> view_bytes(const tinygltf::Model& model, std::size_t view);

/// The bytes of a "data:" URI. Throws Error beginning with `place` for any other kind than base64 of PNG, JPEG, WebP, AVIF or a
/// buffer.
std::vector<std::byte> data_uri_bytes(const std::string& uri, const std::string& place);
bool is_data_uri(const std::string& uri);

/// A URI as a file name: %20 as a space.
std::string decoded_uri(std::string_view uri);

/// "accessors[3]: "
std::string entry(const char* list, std::size_t at);

/// Calls `use` with a zero of the type that components are stored as; unknown ones are taken for float.
template <class Use>
auto with_component(int type, const Use& use)
{
    switch (type)
    {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return use(std::int8_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return use(std::uint8_t{});
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return use(std::int16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return use(std::uint16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return use(std::uint32_t{});
    default:
        return use(float{});
    }
}

/// Null where it has none.
inline const Value* extension_of(const Value& map, std::string_view name)
{
    const Value* const extensions = map.find("extensions");
    return extensions == nullptr ? nullptr : extensions->find(name);
}

/// The rows of an accessor, checked to lie inside of their view.
struct AccessorRows
{
    const unsigned char* first = nullptr;
    std::size_t count = 0;
    std::size_t stride = 0;
    std::size_t components = 0;
    int component_type = 0;
    bool normalized = false;
    std::shared_ptr<const std::vector<unsigned char>> copy;  ///< A sparse accessor's rows; others lie in the model.

    /// The number, from 0 to 1 (-1 to 1 if signed) for normalized integers.
    double at(std::size_t row, std::size_t component) const;
};

/// Throws Error naming the accessor: one that does not exist, has neither a view nor sparse rows, has other than `least` to
/// `most` components, or does not fit its view; sparse rows that are not in order, or more rows than the file has bytes.
AccessorRows accessor_rows(const tinygltf::Model& model, int accessor, std::size_t least, std::size_t most);

/// The triangles of a primitive: three numbers each. `indices` < 0: the vertices in their order. Strips and fans are taken apart;
/// lines and points give none. Throws Error for an index that is not below `vertex_count`.
std::vector<std::uint32_t> triangle_indices(const tinygltf::Model& model, int indices, int mode, std::size_t vertex_count);

}  // namespace fresco::gltf

#pragma once

#include <fresco/mesh.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file What a PLY file declares: for the reader, and for programs that write a changed copy of a file.

namespace fresco
{

enum class PlyType : std::uint8_t
{
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    float32,
    float64
};

constexpr std::size_t size_of(PlyType type)
{
    constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}
constexpr bool is_integer(PlyType type)
{
    return type < PlyType::float32;
}
std::string_view name_of(PlyType type);

struct PlyProperty
{
    std::string name;
    bool is_list = false;
    PlyType count_type = PlyType::uint8;  ///< Type of a list's count.
    PlyType type = PlyType::float32;      ///< The value's, or of a list's items.
    std::string line;                     ///< As declared.
};

struct PlyElement
{
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;
    std::size_t line = 0;  ///< Line of the declaration.
};

enum class PlyFormat
{
    ascii,
    little_endian,
    big_endian
};

struct PlyHeader
{
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    std::vector<MeshFileName> pictures;  ///< Pictures of the `comment TextureFile NAME` lines.
    std::vector<std::string> comments;   ///< The other lines of comments, and those of obj_info.
    int texture_px = 0;                  ///< N of `comment texture_px N`.
    Vec3d offset_m{};                    ///< X Y Z of `comment offset_m X Y Z`.
    std::size_t lines = 0;               ///< Lines of the header.
    std::size_t body_offset = 0;         ///< Bytes of the header.
};

/// Reads the header and checks that the counts it declares fit into the bytes that follow: nothing has to be allocated on a
/// header's word alone. Throws Error with `source` and the line.
PlyHeader parse_ply_header(std::span<const std::byte> bytes, std::string_view source);

/// Whether a property of faces holds the vertex indices: two names are in use.
bool is_index_list(const PlyElement& element, const PlyProperty& property);

}  // namespace fresco

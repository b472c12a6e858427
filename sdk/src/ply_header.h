#pragma once

#include <fresco/mesh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file What a PLY file declares, and where the reader finds what a mesh needs in it.

namespace fresco::detail
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
    int texture_px = 0;                  ///< N of `comment texture_px N`.
    Vec3d offset_m{};                    ///< X Y Z of `comment offset_m X Y Z`.
    std::size_t lines = 0;               ///< Lines of the header.
    std::size_t body_offset = 0;         ///< Bytes of the header.
};

/// Reads the header and checks that the counts it declares fit into the bytes that follow: nothing has to be allocated on a
/// header's word alone. Throws Error with `source` and the line.
PlyHeader parse_ply_header(std::span<const std::byte> bytes, std::string_view source);

/// A triangle's list of indices has at least this many items.
inline constexpr std::size_t least_corners = 3;
/// The property of faces or strips that holds the vertex indices (two names are in use).
bool is_index_list(const PlyElement& element, const PlyProperty& property);

// Destination of a vertex property; others are skipped.
enum VertexSlot : std::size_t
{
    slot_x,
    slot_y,
    slot_z,
    slot_red,
    slot_green,
    slot_blue,
    slot_u,
    slot_v,
    slot_count,
    slot_none = slot_count
};

/// The header's declarations of the two elements of a mesh.
struct PlyLayout
{
    const PlyElement* vertex = nullptr;
    const PlyElement* face = nullptr;  ///< Faces or triangle strips.
    bool is_strips = false;
    std::vector<VertexSlot> slots;  ///< One per vertex property.
    const PlyProperty* indices = nullptr;
    const PlyProperty* texcoord = nullptr;
    const PlyProperty* chart = nullptr;
    const PlyProperty* picture = nullptr;         ///< The face property `texnumber`, if the caller wants it.
    const PlyProperty* vertex_integer = nullptr;  ///< Property that PlyIntegers names.
    const PlyProperty* face_integer = nullptr;
    std::array<const PlyProperty*, 3> face_colors{};  ///< Red, green, blue of faces, or nullptr.
    bool has_colors = false;
    PlyType color_type = PlyType::uint8;
    bool has_vertex_texcoords = false;
};

/// Finds the parts of a mesh in a file; `integer`: the property of PlyIntegers, or nullptr. Refers to the header. Throws
/// Error naming `source` for a file that is no mesh.
PlyLayout ply_layout(const PlyHeader& header, std::string_view source, const std::string* integer);

}  // namespace fresco::detail

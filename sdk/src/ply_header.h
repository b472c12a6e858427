#pragma once

#include <fresco/ply_header.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// \file Where the reader finds what a mesh needs in a PLY file.

namespace fresco::detail
{

/// A triangle's list of indices has at least this many items.
inline constexpr std::size_t least_corners = 3;

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
    const PlyElement* face = nullptr;
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

#pragma once

#include "ply_header.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace fresco::detail
{

// Where a vertex property goes; the rest is skipped.
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

/// What the header says about the two elements a mesh is made of.
struct PlyLayout
{
    const PlyElement* vertex = nullptr;
    const PlyElement* face = nullptr;
    std::vector<VertexSlot> slots;  ///< One per vertex property.
    const PlyProperty* indices = nullptr;
    const PlyProperty* texcoord = nullptr;
    const PlyProperty* chart = nullptr;
    const PlyProperty* picture = nullptr;         ///< The face property `texnumber`, if the caller wants it.
    const PlyProperty* vertex_integer = nullptr;  ///< What PlyIntegers names.
    const PlyProperty* face_integer = nullptr;
    bool has_colors = false;
    bool has_vertex_texcoords = false;
};

/// Where in a file the parts of a mesh are; `integer`: the property of PlyIntegers, or nullptr. Refers to the header. Throws
/// Error naming `source` for a file that is no mesh.
PlyLayout ply_layout(const PlyHeader& header, std::string_view source, const std::string* integer);

}  // namespace fresco::detail

#pragma once

#include <fresco/mesh.h>
#include <fresco/model.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

inline constexpr std::uint32_t no_label = std::numeric_limits<std::uint32_t>::max();

/// A surface whose faces have names.
struct LabeledSurface
{
    fresco::Mesh mesh;
    std::vector<std::string> names;            ///< Each once.
    std::vector<std::uint32_t> label_of_face;  ///< F; index into names, or no_label.
};

enum class Naming
{
    nyu40,   ///< ScanNet's ids, 1 to 40; 0 and others: no label.
    numbers  ///< The integer itself; negative: no label.
};

/// The integers of a PLY's property as labels. Those of vertices are voted onto faces: what two corners have, or the first.
/// `moved`: a mesh with the same vertices at other places, which then count; may be null. Throws Error naming `source`.
LabeledSurface surface_from_ply(std::span<const std::byte> bytes, const std::string& source, const std::string& property,
                                Naming naming, const fresco::Mesh* moved);

/// ScanNet's segmentation: `segments` (…segs.json) has the segment of each vertex of the mesh, `groups` (….aggregation.json) the
/// objects, each with a label and its segments. Throws Error naming the file.
LabeledSurface surface_from_segments(const std::string& groups, const std::string& groups_source, const std::string& segments,
                                     const std::string& segments_source, const fresco::Mesh& mesh);

/// The names of a model's materials; faces whose material has none have no label. Throws Error where none has a name.
LabeledSurface surface_from_materials(const fresco::Model& model);

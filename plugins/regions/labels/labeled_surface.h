#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

/// \file Reads labels of faces from PLY, JSON of ScanNet and Matterport3D or a model's materials, and carries them to another
/// mesh of the same surface. The stage turns them into regions.

inline constexpr std::uint32_t no_label = std::numeric_limits<std::uint32_t>::max();

/// A surface whose faces have names.
struct LabeledSurface
{
    fresco::Mesh mesh;
    std::vector<std::string> names;            ///< Unique.
    std::vector<std::uint32_t> label_of_face;  ///< F; index into names, or no_label.
};

enum class Naming
{
    nyu40,   ///< ScanNet's ids, 1 to 40; 0 and others: no label.
    numbers  ///< The integer itself; negative: no label.
};

/// The integers of a PLY's property as labels. Labels of vertices are voted onto faces: that of two corners, or of the first.
/// `moved`: a mesh with the same vertices at other positions to use instead; may be null. Throws Error naming `source`.
LabeledSurface surface_from_ply(std::span<const std::byte> bytes, const std::string& source, const std::string& property,
                                Naming naming, const fresco::Mesh* moved);

/// ScanNet's or Matterport3D's segmentation: `segments` has the segment of each vertex (….segs.json) or face (….fsegs.json) of
/// the mesh, `groups` (….aggregation.json, ….semseg.json) the objects, each with a label and its segments. Throws Error naming
/// the file.
LabeledSurface surface_from_segments(const std::string& groups, const std::string& groups_source, const std::string& segments,
                                     const std::string& segments_source, const fresco::Mesh& mesh);

/// The names of a model's materials; faces whose material has no name have no label. Throws Error if no material has a name.
LabeledSurface surface_from_materials(const fresco::Model& model);

struct CarriedLabels
{
    std::vector<std::uint32_t> label_of_face;  ///< Per face of the other mesh: index into the surface's names, or no_label.
    double covered_share = 0;                  ///< Share of that mesh's area closer to the surface than the limit.
    double mean_distance_m = 0;                ///< Mean distance of those faces' middles from the surface.
};

/// The labels for another mesh of the same surface: each face gets the label of the face closest to its middle, if that is closer
/// than `within_m`. Equal for any number of threads. Throws Canceled.
CarriedLabels carried_labels(const LabeledSurface& from, const fresco::Mesh& to, double within_m,
                             const fresco::Progress& progress);

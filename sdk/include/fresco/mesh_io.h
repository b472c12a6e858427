#pragma once

#include <fresco/file_format.h>
#include <fresco/mesh.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

FileFormat ply_format();
FileFormat obj_format();

/// Limits that bound memory and time on hostile input.
struct MeshLimits
{
    std::size_t max_vertices = 200'000'000;
    std::size_t max_faces = 400'000'000;
};

/// What a reader had to leave out or change; 0 everywhere for a clean file.
struct MeshReadReport
{
    std::size_t polygons_split = 0;      ///< Faces with more than three corners, fanned into triangles.
    std::size_t degenerate_dropped = 0;  ///< Triangles that name a vertex twice.
};

/// A name that a mesh file gives, and its line.
struct MeshFileName
{
    std::string name;
    std::size_t line = 0;
};

/// What a mesh file says about materials: names only, nothing is opened.
struct MeshMaterials
{
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    std::vector<MeshFileName> files;  ///< OBJ: the text after each `mtllib`; PLY: the picture after each `comment TextureFile`.
    std::vector<MeshFileName> names;  ///< OBJ: the materials by first use; PLY: empty.
    /// F or empty; `none` for faces without. OBJ: index into names; PLY: the face property `texnumber`, an index into files.
    std::vector<std::uint32_t> of_face;
    std::vector<std::uint8_t>
        has_texcoords;  ///< F, if only some faces have texcoords, those of the others being (0, 0); else empty.
};

/// The integers of one property of a PLY file.
struct PlyIntegers
{
    std::string property;                 ///< Its name, to be set by the caller.
    std::vector<std::int64_t> of_vertex;  ///< V, or empty: vertices do not have it.
    std::vector<std::int64_t> of_face;    ///< F, or empty.
};

/// Strict PLY reader: ASCII, binary of both byte orders, float and double coordinates, any integer index and count type, vertex
/// colors (uchar red/green/blue), corner texcoords (face list `texcoord`) or vertex ones (s,t / u,v / texture_u,texture_v), face
/// `chart`; unknown elements and properties are skipped. Throws Error naming `source`, the line (header, ASCII) or byte offset
/// (binary), what was expected and what to do; a file cut at any byte, text after the data, counts beyond the file's size,
/// indices out of range, coordinates that are not finite, 0 faces are errors.
Mesh parse_ply(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits = {},
               MeshReadReport* report = nullptr);
/// With what the file says about pictures.
Mesh parse_ply(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
               MeshMaterials& materials);

/// With the integers of a property. Throws Error, too, if neither vertices nor faces have it, naming those that they have.
Mesh parse_ply(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
               PlyIntegers& integers);

/// Strict Wavefront OBJ reader: v (with optional color), vt, vn, f with all index forms (negative too); groups, materials and
/// smoothing are skipped. Errors as above, by line. A file that does not end in a newline is taken as cut and refused.
Mesh parse_obj(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits = {},
               MeshReadReport* report = nullptr);
/// With what the file says about materials. Texture coordinates may be missing on some faces.
Mesh parse_obj(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
               MeshMaterials& materials);

/// By extension (.ply, .obj). Throws MissingInput if the file cannot be read.
Mesh read_mesh(const std::filesystem::path& file, const MeshLimits& limits = {}, MeshReadReport* report = nullptr);
Mesh read_mesh(const std::filesystem::path& file, const MeshLimits& limits, MeshReadReport* report, MeshMaterials& materials);

/// Binary little-endian PLY of everything the mesh holds; parse_ply gives the same mesh back, bit by bit, but for faces that name
/// a vertex twice (Mesh::load keeps those). Throws Error for what check_mesh refuses and for numbers beyond PLY's int.
std::vector<std::byte> to_ply(const Mesh& mesh);

}  // namespace fresco

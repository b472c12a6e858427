#pragma once

#include <fresco/artifact.h>
#include <fresco/math.h>

#include <array>
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

struct FileFormat;
class RunContext;

using Triangle = std::array<std::uint32_t, 3>;

/// An indexed triangle mesh, world frame less offset_m, meters. Faces are counter-clockwise seen from outside.
/// It need not be manifold: edges may have more than two faces, a vertex may join fans that share no edge, and faces may be
/// duplicate, without area or turned over, as in scans. `fresco::geometry` repairs what an algorithm cannot take.
/// On disk: `mesh.ply`, binary little-endian, with `list uchar float texcoord` and `int chart` per face where present, and
/// `comment texture_px N` where the texture's size is known, `comment offset_m X Y Z` where there is an offset.
struct Mesh : Artifact
{
    static constexpr std::string_view artifact_name = "mesh";
    static constexpr int artifact_version = 1;
    static constexpr std::string_view file_name = "mesh.ply";

    std::vector<Vec3f> positions;       ///< V
    std::vector<Rgb8> colors;           ///< V or empty; sRGB
    std::vector<Triangle> triangles;    ///< F; indices < V
    std::vector<Vec2f> texcoords;       ///< 3F, one per corner, or empty; uv in [0,1], origin at the lower left
    std::vector<std::uint32_t> charts;  ///< F or empty: the atlas chart of each face, counted from 0
    /// Texels per side of the texture that the texcoords are laid out for; 0: unknown. The one source of that size: uv maps pass
    /// it on, and what paints takes it.
    int texture_px = 0;
    /// Position in the world of the point (0, 0, 0), where floats would be too coarse for the world's coordinates (offset_for).
    /// Meshes and frames that belong together have one offset; exports may put it back.
    Vec3d offset_m{};
    /// The folder of a mesh artifact in the store that is equal to this one, such as Input::folder: save links its file instead
    /// of writing the mesh again. Empty: save writes it. Not loaded.
    std::filesystem::path saved_in{};

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Mesh> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
};

/// Throws Error naming `source` and the first offence: no faces, an index out of range, a position that is not finite or more
/// than 1e7 m from the world's origin along an axis, faces of less than 1e-8 m² in all, arrays whose sizes do not match, a
/// texcoord that is not finite.
void check_mesh(const Mesh& mesh, std::string_view source);

/// The offset that float needs for these points of the world: zero, or along each axis on which floats at the points' median are
/// more than 0.1 mm apart (from 1024 m) and 0 is farther off than the points are from each other along any axis, but for a
/// quarter of them: the median rounded to 100 m.
Vec3d offset_for(std::span<const Vec3d> points);
/// Gives the mesh these positions of the world, V, and this offset.
void place(Mesh& mesh, std::span<const Vec3d> positions, Vec3d offset_m);
/// V positions in the world. With an offset rounded to 10 µm, about a step of float, so that short decimals come back.
std::vector<Vec3d> world_positions(const Mesh& mesh);
/// Says and reports (`offset_m`) an offset that a reader took off; nothing for zero.
void tell_offset(Vec3d offset_m, RunContext& run);

/// Identifies an atlas: a hash of the triangles and texcoords, 32 hexadecimal digits. Textures and uv maps carry
/// it, so that a stage can refuse a texture that was made for another atlas.
std::string atlas_id(const Mesh& mesh);
/// Throws Error unless `id`, of what `source` names ("the texture on port 'start'"), is the mesh's atlas_id. An empty id is
/// unknown and passes.
void check_atlas(const std::string& id, const Mesh& mesh, std::string_view source);

/// F normals by the right-hand rule, unit length; zero for degenerate faces.
std::vector<Vec3f> face_normals(const Mesh& mesh);
/// V normals: area-weighted mean of the faces around, unit length; zero where there is none.
std::vector<Vec3f> vertex_normals(const Mesh& mesh);

/// Continuation of a picture outside of [0,1].
enum class Wrap : std::uint8_t
{
    repeat,
    mirror,
    clamp
};

/// Appearance of a face: the product of the color, the picture and the vertex colors, in linear light.
struct ModelMaterial
{
    static constexpr int no_picture = -1;

    std::string name;
    Vec3f color{1, 1, 1};      ///< Linear light, 0 to 1.
    int picture = no_picture;  ///< Index into Model::pictures.
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    bool vertex_colors = false;  ///< The mesh's colors count.
};

/// A surface as another program textured it: several materials, each with its color and picture. Positions in the world, meters.
/// On disk: `mesh.ply`, `model.json`, `materials.npy` (uint32 F: the material of each face), and the pictures as PNG or JPEG.
struct Model : Artifact
{
    static constexpr std::string_view artifact_name = "model";
    static constexpr int artifact_version = 1;

    Mesh mesh;  ///< Its texcoords may lie outside of [0,1].
    std::vector<ModelMaterial> materials;
    std::vector<std::uint32_t> material_of_face;  ///< F; indices into materials.
    /// File names. The stage that makes a model writes each one into its output's folder().path.
    std::vector<std::string> pictures;
    std::filesystem::path loaded_from;  ///< Folder where load() found the pictures. Not saved.

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Model> load(const ArtifactFolder& folder);
};

/// Throws Error naming `source` and the first offence: what check_mesh refuses, a face without a material, a material whose
/// picture is missing or whose color is not finite and from 0 to 1, a material with a picture on a mesh without texcoords, one
/// with vertex colors on a mesh without.
void check_model(const Model& model, std::string_view source);

FileFormat ply_format();
FileFormat obj_format();

/// Limits that bound memory and time on hostile input.
struct MeshLimits
{
    std::size_t max_vertices = 200'000'000;
    std::size_t max_faces = 400'000'000;
};

/// Positions in full precision, and counts of what a reader left out or changed: 0 everywhere for a clean file.
struct MeshReadReport
{
    std::vector<Vec3d> positions;        ///< V, as the file has them; the mesh has them as offset_for says.
    std::size_t polygons_split = 0;      ///< Faces with more than three corners, fanned into triangles.
    std::size_t degenerate_dropped = 0;  ///< Triangles that name a vertex twice.
};

/// A name that a mesh file gives, and its line.
struct MeshFileName
{
    std::string name;
    std::size_t line = 0;
};

/// A statement that begins a part of an OBJ.
struct MeshGroup
{
    bool is_object = false;  ///< `o`; else `g`.
    std::string name;
};

/// Materials that a mesh file names; no file is opened.
struct MeshMaterials
{
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    std::vector<MeshFileName> files;  ///< OBJ: the text after each `mtllib`; PLY: the picture after each `comment TextureFile`.
    std::vector<MeshFileName> names;  ///< By first use. OBJ: the materials; PLY: the colors of faces, as "#ff8000".
    /// F or empty; `none` for faces without. Index into names; PLY with files: the face property `texnumber`, index into files.
    std::vector<std::uint32_t> of_face;
    std::vector<std::uint8_t>
        has_texcoords;              ///< F, if only some faces have texcoords, those of the others being (0, 0); else empty.
    std::vector<MeshGroup> groups;  ///< OBJ: the statements `o NAME` and `g NAME`, in their order.
    std::vector<std::uint32_t> group_of_face;  ///< F with groups: the last before the face, `none` for faces before the first.
};

/// The integers of one property of a PLY file.
struct PlyIntegers
{
    std::string property;                 ///< Its name, to be set by the caller.
    std::vector<std::int64_t> of_vertex;  ///< V, or empty: vertices do not have it.
    std::vector<std::int64_t> of_face;    ///< F, or empty.
};

/// Strict PLY reader: ASCII, binary of both byte orders, coordinates, indices and counts of any type,
/// vertex colors (red/green/blue, diffuse_red/…, r/g/b) of any type, corner texcoords (face list `texcoord`) or vertex ones
/// (s,t / u,v / texture_u,texture_v), face `chart`; unknown elements and properties are skipped, as are more numbers on a line.
/// Throws Error naming `source`, the line (header, ASCII) or byte offset (binary), what was expected and what to do; a file cut
/// at any byte except for a last newline behind a whole number, text after the data, counts beyond the file's size, indices out
/// of range, coordinates that are not finite, 0 faces are errors.
///
/// `materials` and `integers` may be null; they receive what the file says about pictures, and the values of the property that
/// `integers` names. Throws Error, too, if neither vertices nor faces have that property, naming those that they have.
Mesh parse_ply(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits = {},
               MeshReadReport* report = nullptr, MeshMaterials* materials = nullptr, PlyIntegers* integers = nullptr);

/// Strict Wavefront OBJ reader: v (with optional color), vt, vn, f with all index forms (negative too); smoothing and normals
/// are skipped. Colors go to 1 or to 255. Errors as above, by line. A last line without an end is
/// taken as cut and refused, unless it is a face of which nothing can be missing. With `materials`, which receives what the file
/// says about them, texture coordinates may be missing on some faces.
Mesh parse_obj(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits = {},
               MeshReadReport* report = nullptr, MeshMaterials* materials = nullptr);

/// By extension (.ply, .obj). Throws MissingInput if the file cannot be read.
Mesh read_mesh(const std::filesystem::path& file, const MeshLimits& limits = {}, MeshReadReport* report = nullptr,
               MeshMaterials* materials = nullptr);

/// Binary little-endian PLY of everything the mesh holds; parse_ply gives the same mesh back, bit by bit, but for faces that name
/// a vertex twice (Mesh::load keeps those). Throws Error for what check_mesh refuses and for numbers beyond PLY's int.
std::vector<std::byte> to_ply(const Mesh& mesh);

}  // namespace fresco

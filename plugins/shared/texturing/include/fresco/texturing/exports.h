#pragma once

#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/relief.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/relief_maps.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// \file What the stages that write meshes share: checks of what goes in, pictures and their options, vertices split as a format
/// wants them, PLY.

namespace fresco::texturing
{

/// Throws Error naming `source` unless the mesh is one that can be exported: as check_mesh, with texcoords, and a square picture.
void check_textured_mesh(const TexturedMesh& textured, std::string_view source);

/// "1 234 567"
std::string grouped(std::uint64_t number);
/// "12.3 MB", "4.0 kB", "17 bytes"; of 1000, as file managers count.
std::string file_size(std::uint64_t bytes);

/// Says what was written, "room.glb: 12.3 MB, 499 999 triangles, picture of 4096 x 4096 in 9.8 MB", and reports these numbers.
/// `texture_px`: 0 without a picture.
void tell_export(RunContext& run, const std::string& name, std::size_t bytes, std::size_t triangles, int texture_px,
                 std::size_t picture_bytes);

/// Input of an export, wired as one of two: a mesh with its picture, or one without. Declared in the stage as
/// `ExportedMesh mesh{this};`.
class ExportedMesh
{
  public:
    explicit ExportedMesh(Configurable* owner);

    /// Throws Error unless one of the ports is wired, to what can be exported (check_textured_mesh, check_mesh).
    void check() const;

    bool has_picture() const { return textured_.has_value(); }
    const TexturedMesh& textured() const { return *textured_; }
    const Mesh& mesh() const { return has_picture() ? textured_->mesh : *mesh_; }

  private:
    Input<TexturedMesh> textured_;
    Input<Mesh> mesh_;
};

/// Throws Error if a path below --out contains spaces, at which readers of text headers split names.
void check_path_for_names(const std::string& path);

/// The options of an export that encodes the picture of a textured mesh: declared in the stage as
/// `PictureEncoding encoding{this};`.
class PictureEncoding
{
  public:
    /// `max_texture_px`: the default of the option.
    explicit PictureEncoding(Configurable* owner, int max_texture_px = 0);

    struct Encoded
    {
        Raster8 smaller;  ///< Empty where the picture keeps its size: large ones are not copied.
        std::vector<std::byte> bytes;

        const Raster8& picture(const TexturedMesh& textured) const { return smaller.empty() ? textured.image.pixels : smaller; }
    };
    /// The picture, made smaller where that is asked for, as `extension` says: ".png", ".jpg" or ".jpeg", ".npy" (uint8 H x W
    /// x 3). Throws Error for any other; Canceled.
    Encoded encoded(const TexturedMesh& textured, std::string_view extension, RunContext& run) const;
    struct EncodedRelief
    {
        std::vector<std::byte> normals;
        std::vector<std::byte> roughness;
    };
    /// The maps of relief_maps.h, made smaller in the same way. Throws Error for a relief of another atlas; Canceled.
    EncodedRelief encoded(const Relief& relief, const Mesh& mesh, NormalFrame frame, std::string_view extension,
                          RunContext& run) const;
    const ImageIo& images() const { return *images_; }
    /// Writes the picture as `name`, whose extension is as in encoded(), to a folder that exists, and says so. Throws Error,
    /// Canceled.
    void write(const TexturedMesh& textured, const std::filesystem::path& folder, const std::string& name, RunContext& run) const;

  private:
    Option<int> max_texture_px_;
    Slot<ImageIo> images_;
};

/// PictureEncoding with the format as an option: declared in the stage as `PictureOptions picture{this};`.
class PictureOptions : public PictureEncoding
{
  public:
    explicit PictureOptions(Configurable* owner);

    /// ".png" or ".jpg".
    std::string extension() const;

  private:
    Option<std::string> image_format_;
};

/// A mesh with one texcoord per vertex, as graphics hardware wants it.
struct WeldedMesh
{
    std::vector<Vec3f> positions;                ///< V
    std::vector<Vec3f> normals;                  ///< V, unit length: area-weighted over all faces at the position, across seams.
    std::vector<Vec2f> texcoords;                ///< V or empty, origin at the lower left.
    std::vector<Rgb8> colors;                    ///< V or empty; sRGB.
    std::vector<std::array<float, 4>> tangents;  ///< V or empty: see add_tangents.
    std::vector<std::uint32_t> indices;          ///< 3F, in the order of the mesh's corners.
};

/// Corners with the same position and the same texcoord become one vertex, numbered by first use; no face is dropped. The mesh
/// must have passed check_mesh. `with_colors`: corners of one vertex have the same color, too, and the colors are kept.
WeldedMesh weld(const Mesh& mesh, bool with_colors = false);

/// The frames that a normal map is in. A tangent is a unit vector square to the normal, along growing u, and 1 or -1: this times
/// cross(normal, tangent) runs along growing v, up in the picture; -1 where a chart shows the surface as a mirror does. Faces
/// count by their angle at the vertex, as in MikkTSpace (Mikkelsen, "Simulation of wrinkled surfaces revisited", 2008), which
/// glTF names. A vertex where mirrored and other charts share a texcoord becomes two.
void add_tangents(WeldedMesh& mesh);

/// The mesh with one texcoord per vertex: corners that agree in position and texcoord are one vertex, with the vertex's color. A
/// mesh without texcoords stays as it is. Drops charts.
Mesh split_at_seams(const Mesh& mesh);

/// Binary little-endian PLY of a mesh of split_at_seams. PLY has no standard for texcoords: here they are `s` and `t` of each
/// vertex, as Blender reads them. `picture`: the name for `comment TextureFile`, empty for none. `in_world`: of a mesh with an
/// offset the world_positions, as `double`. Throws Error for more vertices than PLY's int counts.
std::vector<std::byte> textured_ply(const Mesh& mesh, const std::string& picture, bool in_world = false);

}  // namespace fresco::texturing

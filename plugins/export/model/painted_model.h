#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/recordings/listed_files.h>
#include <fresco/run_context.h>
#include <fresco/value.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

/// \file Puts a painted picture into the file of a model, of which everything else stays as it is.

namespace export_model
{

struct Picture
{
    std::vector<std::byte> bytes;
    std::string extension;  ///< ".png" or ".jpg"
};

/// The painting that a model's file gets.
struct Painting
{
    const fresco::Mesh& atlas;  ///< The file's triangles in its order, with the texcoords of the picture.
    /// The file has these texcoords already: its own stay, and the picture takes the place of the material's.
    bool keeps_uvs = false;
    /// Encodes the picture. `cutout`: the faces whose old pictures have transparent parts that count, as F flags, or empty.
    std::function<Picture(const std::vector<bool>& cutout)> picture;
    std::string name;      ///< Name of the files to write, without extension.
    fresco::Value origin;  ///< How it was made (RunContext::origin), for a GLB's asset.extras.
};

struct PaintedFiles : fresco::recordings::FileNotes
{
    /// Names and contents; the model's own file is the first.
    std::vector<std::pair<std::string, std::string>> files;
    std::vector<std::filesystem::path> files_read;  ///< In addition to the model's own.
    std::size_t vertices_added = 0;                 ///< Copies along the seams of the new texcoords.
    std::size_t polygons_split = 0;                 ///< Polygons across such a seam, cut into triangles.
};

/// A GLB of a GLB or glTF file. With the file's texcoords, only the base color's picture changes, and what multiplied it (the
/// base color factor, COLOR_0) goes. Otherwise each painted primitive gets one more set of texcoords, for which vertices are
/// copied along seams, and its material points to the picture through it. Positions, the order of triangles, nodes, skins,
/// animations, other textures, extras and unknown extensions stay. Buffers and pictures beside the file become parts of the GLB.
/// Throws Error, MissingInput.
PaintedFiles painted_gltf(const std::filesystem::path& file, const Painting& painting);

/// An OBJ with its MTL and the picture. Vertices, normals, faces, groups and names of materials stay; texture coordinates are
/// replaced where they are not kept. Throws Error, MissingInput.
PaintedFiles painted_obj(const std::filesystem::path& file, const Painting& painting);

/// A PLY and the picture. All elements and properties stay; texcoords that are not kept are replaced by the face property
/// `texcoord`. Throws Error, MissingInput.
PaintedFiles painted_ply(const std::filesystem::path& file, const Painting& painting);

/// The opacity that a model's pictures have in the faces of an atlas, S x S, continued between the charts. `pictures`: RGB or,
/// where a picture has transparent parts, RGBA; `cutout`: F, the faces whose opacity counts. The model's faces are the atlas's.
/// Throws Canceled.
fresco::Raster8 cutout_alpha(const fresco::Model& model, const std::vector<fresco::Raster8>& pictures, const fresco::Mesh& atlas,
                             const std::vector<bool>& cutout, int size_px, fresco::RunContext& run);

/// Throws Error if a file with this many triangles is not the one that the atlas was made of.
void check_faces(const std::filesystem::path& file, std::size_t faces, const Painting& painting);

}  // namespace export_model

#pragma once

#include <fresco/mesh.h>
#include <fresco/recordings/listed_files.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file Reads a mesh or model file: its shape, and the materials and pictures that it names. read_file_model() is the way in for
/// the stage and the fuzzer; glTF has its own file (gltf_model.cpp). Files are foreign, so all of this refuses instead of
/// trusting.

namespace scan_mesh
{

/// PLY, OBJ, GLB and glTF.
std::vector<fresco::FileFormat> model_formats();

/// A picture of a model, not decoded: a file, or bytes in the model's file.
struct FilePicture
{
    std::string name;  ///< For messages.
    std::filesystem::path file;
    std::vector<std::byte> bytes;  ///< If `file` is empty.
};

/// Extension of a picture with these bytes: ".png", ".jpg", ".webp", ".bmp" or ".heic" (AVIF too); empty for anything else.
std::string_view suffix_of(std::span<const std::byte> picture);

/// A picture without its ICC profile: PNG, JPEG or WebP. Others, and damaged ones, stay as they are.
std::vector<std::byte> without_profile(std::vector<std::byte> picture);

/// A model as read, in the file's axes and unit.
struct FileModel : fresco::recordings::FileNotes
{
    fresco::Mesh mesh;
    std::vector<fresco::ModelMaterial> materials;
    std::vector<std::uint32_t> material_of_face;
    std::vector<std::string> objects;           ///< Paths of glTF's nodes, or of an OBJ's objects and groups: "house/door".
    std::vector<std::uint32_t> object_of_face;  ///< F, or empty without objects; objects.size() for faces that are of none.
    std::vector<FilePicture> pictures;
    std::vector<std::filesystem::path> files_read;  ///< In addition to the model's own.
    std::vector<std::string> warnings;
    fresco::MeshReadReport report;
    bool split_vertices = false;  ///< The format splits vertices with several texcoords.
    bool is_gltf = false;         ///< Color profiles of the pictures do not count.
};

/// Reads PLY, OBJ, GLB or glTF by the extension. Without materials: the shape, texcoords and vertex colors, and one material.
/// Opens nothing outside of the file's folder. A material or picture that an OBJ or PLY names and that is missing gives a
/// warning. Throws MissingInput and Error, naming the file and the line, byte or entry.
FileModel read_file_model(const std::filesystem::path& file, bool with_materials);

/// Numbers the objects that a file names.
class ObjectNumbers
{
  public:
    static constexpr std::size_t most_objects = 65'000;

    /// The number of a path, such as "house/door"; most_objects for an empty one, and for further ones beyond so many.
    std::uint32_t number_of(const std::string& path);
    std::size_t count() const { return numbers_.size(); }
    /// The paths by their numbers.
    std::vector<std::string> paths() const;
    /// The path of an object within another. Names and paths that are very long are left out, for a file could repeat them.
    static std::string path(const std::string& outer, std::string_view name);

  private:
    std::map<std::string, std::uint32_t> numbers_;
};

/// The glTF part of read_file_model.
FileModel read_gltf_model(const std::filesystem::path& file, bool with_materials);

/// The advice at the end of errors about missing materials and pictures.
inline constexpr std::string_view shape_only = ", or set materials: skip for the shape only";

}  // namespace scan_mesh

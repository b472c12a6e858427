#pragma once

#include <fresco/mesh_io.h>
#include <fresco/model.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace scan_mesh
{

/// A picture of a model, not decoded: a file, or the bytes of one that the model's file holds.
struct FilePicture
{
    std::string name;  ///< For messages.
    std::filesystem::path file;
    std::vector<std::byte> bytes;  ///< If `file` is empty.
};

/// A model as its file has it, in the file's axes and unit.
struct FileModel
{
    fresco::Mesh mesh;
    std::vector<fresco::ModelMaterial> materials;
    std::vector<std::uint32_t> material_of_face;
    std::vector<FilePicture> pictures;
    std::vector<std::filesystem::path> files_read;  ///< Beside the model's own.
    std::vector<std::string> warnings;
    fresco::MeshReadReport report;
    bool split_vertices = false;  ///< The format needs a vertex for each texcoord at a position.
};

/// Reads PLY, OBJ, GLB or glTF by the extension. Without materials: the shape, texcoords and vertex colors, and one material.
/// Opens nothing outside of the file's folder. Throws MissingInput and Error, naming the file and the line, byte or entry.
FileModel read_file_model(const std::filesystem::path& file, bool with_materials);

/// The glTF part of read_file_model.
FileModel read_gltf_model(const std::filesystem::path& file, bool with_materials);

/// Lower case, with the dot.
std::string extension_of(const std::filesystem::path& file);

}  // namespace scan_mesh

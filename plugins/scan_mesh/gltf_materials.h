#pragma once

#include "file_folder.h"
#include "file_model.h"

#include <fresco/gltf/gltf_file.h>
#include <fresco/math.h>
#include <fresco/model.h>

#include <array>
#include <map>
#include <string>
#include <utility>

namespace scan_mesh
{

/// How a material of a glTF file takes its picture.
struct GltfLook
{
    fresco::ModelMaterial material;
    int image = -1;  ///< -1: none.
    int texcoord_set = 0;
    std::array<double, 6> picture_from_uv{1, 0, 0, 0, 1, 0};  ///< Rows of a 2 x 3 matrix (KHR_texture_transform).
};

/// The color and picture of a material; white for -1. Without a picture where pictures are not wanted. Throws Error naming the
/// material or texture for numbers and indices that are wrong.
GltfLook look_of(const fresco::gltf::GltfFile& gltf, int material, bool with_pictures);

/// Adds pictures to a model, each once: those that overlap would take any amount of memory.
class GltfPictures
{
  public:
    GltfPictures(const fresco::gltf::GltfFile& gltf, const std::filesystem::path& file, FileModel& model)
        : gltf_(gltf), file_(file), folder_(file), model_(model)
    {
    }

    /// The index in FileModel::pictures. Throws MissingInput, Error.
    int number_of(int image);

  private:
    int next() const { return static_cast<int>(model_.pictures.size()); }
    int added(std::size_t image);
    int added_view(std::size_t view, const std::string& name, const std::string& place);
    int added(FilePicture picture, const std::string& place);

    const fresco::gltf::GltfFile& gltf_;
    const std::filesystem::path& file_;
    FileFolder folder_;
    FileModel& model_;
    std::map<int, int> numbers_;  ///< Of images.
    std::map<std::pair<const std::byte*, std::size_t>, int> of_bytes_;
    std::map<std::filesystem::path, int> of_files_;
    std::size_t taken_bytes_ = 0;  ///< From buffers.
};

}  // namespace scan_mesh

#pragma once

#include "model.h"

#include <fresco/recordings/registered_view.h>

#include <filesystem>
#include <vector>

namespace colmap
{

/// The two files of a reconstruction.
struct ModelFiles
{
    std::filesystem::path cameras;
    std::filesystem::path images;
};

/// The folders below `path` in which a reconstruction is looked for, in this order.
std::vector<std::filesystem::path> model_folders(const std::filesystem::path& path);

/// cameras.bin and images.bin, or else cameras.txt and images.txt, in the first of `folders` that has them. Throws MissingInput
/// if none has.
ModelFiles find_model(const std::vector<std::filesystem::path>& folders);

/// Throws what the parsers throw.
Cameras read_cameras(const std::filesystem::path& file);
std::vector<ModelImage> read_images(const std::filesystem::path& file);

struct ViewOptions
{
    std::filesystem::path pictures;  ///< Folder of the pictures.
    std::filesystem::path depth;     ///< Folder of depth pictures named like them, ending in .png; empty: none.
    double unit_m = 1;               ///< Meters per unit of the reconstruction.
    double depth_unit_m = 0.001;     ///< Meters per step of the depth pictures.
};

/// The views of the images, by name. Throws Error naming the image's place if its camera is not among `cameras`, or if there are
/// no images.
std::vector<fresco::recordings::RegisteredView> model_views(const Cameras& cameras, const std::vector<ModelImage>& images,
                                                            const std::filesystem::path& images_file, const ViewOptions& options);

}  // namespace colmap

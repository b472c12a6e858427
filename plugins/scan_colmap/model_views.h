#pragma once

#include "model.h"

#include <fresco/recordings/recording_files.h>

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

/// cameras.bin and images.bin, or else cameras.txt and images.txt, in the first of the folders below `path` in which tools put a
/// reconstruction. Throws MissingInput if none has them.
ModelFiles find_model(const std::filesystem::path& path, fresco::RunContext& run);

/// Throws what the parsers throw.
Cameras read_cameras(const std::filesystem::path& file);
std::vector<ModelImage> read_images(const std::filesystem::path& file);

struct ViewOptions
{
    std::filesystem::path pictures;  ///< Folder of the pictures.
    std::filesystem::path depth;     ///< Folder of depth pictures named like them, ending in .png; empty: none.
    std::filesystem::path masks;  ///< Folder of masks: a picture's name with .png added, or in place of its ending; empty: none.
    double unit_m;                ///< Meters per unit of the reconstruction.
    double depth_unit_m;          ///< Meters per step of the depth pictures.
};

/// The views of the images, by name. Throws Error naming the image's place if its camera is not among `cameras`, or if there are
/// no images.
std::vector<fresco::recordings::RecordedView> model_views(const Cameras& cameras, const std::vector<ModelImage>& images,
                                                          const std::filesystem::path& images_file, const ViewOptions& options);

}  // namespace colmap

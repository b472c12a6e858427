#pragma once

#include "study.h"

#include <fresco/files.h>
#include <fresco/image_io.h>
#include <fresco/run_context.h>

#include <filesystem>
#include <string>
#include <vector>

namespace study
{

/// The pictures (.png, .jpg, .jpeg) among what a stage made, by the names of the files without extension. Throws Error if two
/// share a name.
MethodPictures pictures_of(const std::string& method, const fresco::Files& views);

/// One method per subfolder, called after it, in alphabetical order; hidden ones and other files are passed over. Notes what was
/// looked for. Throws Error as pictures_of.
std::vector<MethodPictures> pictures_below(const std::filesystem::path& folder, fresco::RunContext& run);

struct ShownAs
{
    int max_px;  ///< Of the longer side; smaller pictures stay as they are.
    bool png;    ///< Else JPEG.
    int jpeg_quality;
};

/// The data URIs of the study's pictures, by number. Those of a group have one size, so that resolution does not give the method
/// away. Throws Error naming the files if shapes in a group differ by more than 1 %, Canceled.
std::vector<std::string> encoded_pictures(const Study& study, const std::vector<Group>& groups, const ShownAs& shown,
                                          const fresco::ImageIo& images, fresco::Progress& progress);

}  // namespace study

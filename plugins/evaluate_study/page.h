#pragma once

#include "study.h"

#include <fresco/files.h>
#include <fresco/image_io.h>
#include <fresco/run_context.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file The page that participants open, and the pictures in it. The stage collects pictures from its ports or from a folder,
/// and writes the page beside the study's key.

namespace study
{

/// The pictures (.png, .jpg, .jpeg) among the files of a stage, by file name without extension. Throws Error if two
/// share a name.
MethodPictures pictures_of(const std::string& method, const fresco::Files& views);

/// One method per subfolder and named after it, in alphabetical order; skips hidden subfolders and other files. Notes the folder
/// as an input of the run. Throws Error as pictures_of.
std::vector<MethodPictures> pictures_below(const std::filesystem::path& folder, fresco::RunContext& run);

struct ShownAs
{
    int max_px;  ///< Maximum of the longer side; smaller pictures keep their size.
    bool png;    ///< Else JPEG.
    int jpeg_quality;
};

/// The data URIs of the study's pictures, by number. The pictures of a group have one size, so that resolution does not reveal
/// the method. Throws Error naming the files if shapes in a group differ by more than 1 %, Canceled.
std::vector<std::string> encoded_pictures(const Study& study, const std::vector<Group>& groups, const ShownAs& shown,
                                          const fresco::ImageIo& images, fresco::Progress& progress);

/// The page that shows the study: one self-contained HTML file that names no method. `pictures`: their data URIs, by
/// number.
std::string page(const Study& study, const std::vector<std::string>& pictures);

}  // namespace study

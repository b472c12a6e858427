#pragma once

#include "written_files.h"

#include <fresco/dataset/manifest.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

/// As fresco::frames_of_views; throws Error too where a frame is there twice, or has another color camera than its view.
std::vector<std::size_t> checked_frames(const fresco::UvMaps& maps, const fresco::Frames& frames);

/// One map, held against fresco::dataset's checks: throws Error naming the view, the height and the pixel.
fresco::UvMap checked_map(const fresco::UvMaps& maps, std::size_t view, std::size_t level);

/// fresco::sharpness as the manifest has it.
double view_sharpness(const fresco::Raster8& picture);

struct ViewOptions
{
    fresco::dataset::UvType uv;
    bool pictures;  ///< Also the camera picture and the mesh's depth (of the largest height) as picture files.
};

/// Writes everything of one view below `folder`: at each height its uv map and its camera picture, resized as the optimizer does
/// it; the camera picture at full size; the depth camera's picture, where there is one. Holds one height at a time. Thread-safe
/// for different views. `images` may be null where every picture is NPY and no picture files are wanted. Throws Error naming the
/// file or the map for what cannot be read, and for values that fresco::dataset's checks refuse.
WrittenFiles write_view(const std::filesystem::path& folder, const fresco::UvMaps& maps, std::size_t view,
                        const fresco::Frame& frame, const fresco::ImageIo* images, const ViewOptions& options);

/// What the manifest says of it.
fresco::dataset::View view_entry(const fresco::UvMaps& maps, std::size_t view, const fresco::Frame& frame,
                                 const WrittenFiles& written);

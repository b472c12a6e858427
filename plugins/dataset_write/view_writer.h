#pragma once

#include <fresco/dataset/manifest.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// As fresco::frames_of_views; throws Error too where a frame is there twice, or has another colour camera than its view.
std::vector<std::size_t> checked_frames(const fresco::UvMaps& maps, const fresco::Frames& frames);

/// What a view added to the dataset.
struct WrittenView
{
    fresco::dataset::View view;
    std::map<std::string, fresco::dataset::FileStamp> files;
};

/// Writes everything of one view below `folder`: at each height its uv map and its camera picture, resized as the optimiser does
/// it; the camera picture at full size; the depth camera's picture, where there is one. Holds one height at a time. Thread-safe
/// for different views. `images` may be null where every picture is NPY. Throws Error naming the file or the map for what cannot
/// be read, and for values that fresco::dataset's checks refuse.
WrittenView write_view(const std::filesystem::path& folder, const fresco::UvMaps& maps, std::size_t view,
                       const fresco::Frame& frame, const fresco::ImageIo* images, fresco::dataset::UvType uv);

#pragma once

#include <fresco/frames.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

struct MaskFile
{
    std::size_t frame = 0;  ///< Index into the frames.
    std::filesystem::path file;
};

/// A region and its masks, by frame.
struct MaskedRegion
{
    std::string name;
    std::vector<MaskFile> masks;
};

/// The files REGION/FRAME.png or .jpg below a folder, where FRAME is a frame's name or <sequence>_<name>; other entries, and
/// those that begin with '.', are passed over. Throws Error naming the file: a picture of no frame, two of one frame, a name that
/// several sequences have; MissingInput for a folder without masks.
std::vector<MaskedRegion> find_masks(const std::filesystem::path& folder, const std::vector<fresco::Frame>& frames);

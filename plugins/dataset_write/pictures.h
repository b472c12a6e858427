#pragma once

#include <fresco/frames.h>
#include <fresco/image_io.h>

#include <cstddef>
#include <string>
#include <vector>

/// \file Pictures in the formats that other programs read.

struct EncodedPicture
{
    std::string extension;  ///< ".png" or ".jpg"
    std::vector<std::byte> bytes;
};

/// The camera picture of a frame: the recorder's own file, byte for byte, where that is JPEG or an 8-bit RGB PNG, and else (16
/// bits, gray, a palette or alpha) `picture` as PNG.
/// Throws Error if the file changed since it was listed.
EncodedPicture encoded_color(const fresco::Frame& frame, const fresco::Raster8& picture, const fresco::ImageIo& images);

/// 16-bit PNG in millimeters, 0 = no depth; depths beyond 65.534 m become 0. `depth`: H x W, meters.
std::vector<std::byte> encoded_depth(const fresco::RasterF& depth, const fresco::ImageIo& images);

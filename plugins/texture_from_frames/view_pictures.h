#pragma once

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/run_context.h>

#include <cstddef>
#include <filesystem>
#include <vector>

/// \file Finds and reads the pictures for the texture: the cameras' own, or those of a folder. Made once by the stage.

namespace fresco::from_frames
{

/// The pictures for the texture: the cameras' own, or those of a folder instead. References its inputs.
/// Thread-safe once made.
class ViewPictures
{
  public:
    /// \param folder  empty: the cameras' own; else one PNG, JPEG or NPY (uint8 H x W x 3) for every frame in `wanted`, named
    ///                <sequence>_<frame>; noted as read
    /// \param images  may be null if every picture is NPY
    /// Throws MissingInput that counts the frames without a picture and names the first ones; Error if two files are for one
    /// frame.
    ViewPictures(const Frames& frames, const std::vector<std::size_t>& wanted, const std::filesystem::path& folder,
                 const ImageIo* images, RunContext& run);

    /// RGB. Throws Error naming the file if it is damaged, or does not have the camera's aspect ratio (to a pixel).
    Raster8 load(std::size_t frame) const;

  private:
    const Frames& frames_;
    const ImageIo* images_;
    std::vector<std::filesystem::path> files_;  ///< Per frame; empty: the cameras' own.
};

/// Whether a picture of this size has the camera's aspect ratio, to a pixel in width or height.
bool fits_camera(int width, int height, const Intrinsics& camera);

}  // namespace fresco::from_frames

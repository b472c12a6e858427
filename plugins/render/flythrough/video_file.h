#pragma once

#include <fresco/image.h>

#include <cstddef>
#include <filesystem>
#include <string>

#include <opencv2/videoio.hpp>

/// \file Writes the stage's pictures as a video.

/// A video that is being written: H.264 or, if OpenCV's FFmpeg has no encoder for it, MPEG-4 in .mp4; VP9 or VP8 in .webm.
class VideoFile
{
  public:
    /// The extension of `file`, .mp4 or .webm, decides the format. Throws Error if no codec for it is available.
    VideoFile(std::filesystem::path file, int width, int height, double fps);

    /// RGB of the video's size.
    void add(const fresco::Raster8& picture);
    /// Ends the file and reads it back, because FFmpeg does not report a full disk. Throws Error if pictures are missing.
    void close();
    /// "avc1"
    const std::string& codec() const { return codec_; }

  private:
    std::filesystem::path file_;
    cv::VideoWriter writer_;
    std::string codec_;
    std::size_t added_ = 0;
};

#pragma once

#include <fresco/image.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// \file Reads the files of ScanNet's recorder: the index of a recording, bytes of its pictures, and compressed depth. The stage
/// unpacks the pictures of the frames that it keeps; the fuzzer calls read_index() and unpack_depth().

namespace sens
{

enum class ColorForm
{
    raw,  ///< RGB, 8 bits, row by row.
    png,
    jpeg
};

enum class DepthForm
{
    raw,  ///< 16 bits, little-endian, row by row.
    zlib  ///< As raw, compressed.
};

/// A camera as stored.
struct SensCamera
{
    int width = 0;
    int height = 0;
    std::vector<double> intrinsics;  ///< Row-major 4x4, pixels; the first pixel's center is at (0, 0).
    std::vector<double> extrinsics;  ///< Row-major 4x4, the recorder's frame from the camera's.
};

/// The position of one frame in the file.
struct SensFrame
{
    std::vector<double> world_from_depth;  ///< Row-major 4x4; not finite if the recorder had lost track.
    std::uint64_t color_offset = 0;
    std::uint64_t color_bytes = 0;
    std::uint64_t depth_offset = 0;
    std::uint64_t depth_bytes = 0;
};

/// The contents of the file except the pictures.
struct SensIndex
{
    SensCamera color;
    SensCamera depth;
    ColorForm color_form = ColorForm::jpeg;
    DepthForm depth_form = DepthForm::zlib;
    double depth_unit_m = 0.001;
    std::vector<SensFrame> frames;
};

/// A recording of ScanNet's recorder, open for reading. read_at may be called from several threads.
class SensFile
{
  public:
    /// Throws MissingInput if the file cannot be opened.
    explicit SensFile(std::filesystem::path path);
    ~SensFile();
    SensFile(const SensFile&) = delete;
    SensFile& operator=(const SensFile&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::uint64_t size() const { return size_; }
    /// Throws Error naming the file, the offset and `what` to read if the file ends before.
    std::vector<std::byte> read_at(std::uint64_t offset, std::uint64_t count, const std::string& what) const;

  private:
    std::filesystem::path path_;
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
};

/// Reads the headers of all frames; skips the pictures, and the data of motion sensors behind them. Allocates no more than the
/// file holds, whatever its counts and sizes say. Throws Error naming file and byte for a version other than 4, pictures beyond
/// 200 megapixels, an unsupported compression, an invalid depth shift, and a truncated frame.
SensIndex read_index(const SensFile& file);

/// Unpacks width x height 16-bit values, little-endian, compressed by zlib (RFC 1950). Throws Error naming `place` for damage and
/// for another number of values; never unpacks more than the picture.
fresco::Raster16 unpack_depth(std::span<const std::byte> packed, int width, int height, const std::string& place);

}  // namespace sens

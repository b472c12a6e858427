#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

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
    zlib  ///< The same, compressed.
};

/// A camera as the file has it.
struct SensCamera
{
    int width = 0;
    int height = 0;
    std::vector<double> intrinsics;  ///< Row-major 4x4, pixels; the first pixel's center is at (0, 0).
    std::vector<double> extrinsics;  ///< Row-major 4x4, the recorder's frame from the camera's.
};

/// Where one frame lies in the file.
struct SensFrame
{
    std::vector<double> world_from_depth;  ///< Row-major 4x4; not finite where the recorder had lost track.
    std::uint64_t color_offset = 0;
    std::uint64_t color_bytes = 0;
    std::uint64_t depth_offset = 0;
    std::uint64_t depth_bytes = 0;
};

/// What stands in the file but the pictures.
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
    /// Throws Error naming the file and the offset, and `what` was to be read, if the file ends before.
    std::vector<std::byte> read_at(std::uint64_t offset, std::uint64_t count, const std::string& what) const;

  private:
    std::filesystem::path path_;
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
};

/// Walks the heads of all frames, passing over the pictures; the data of motion sensors behind them is not looked at. Nothing is
/// allocated for counts and sizes that the file does not hold.
/// Throws Error naming file and byte: another version than 4, pictures beyond 200 megapixels, a compression that is not read, a
/// invalid depth shift, a frame that is cut off.
SensIndex read_index(const SensFile& file);

}  // namespace sens

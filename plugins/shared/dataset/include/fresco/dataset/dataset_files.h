#pragma once

#include <fresco/dataset/manifest.h>
#include <fresco/image.h>
#include <fresco/npy.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

/// \file The files of a prepared dataset: whole, as listed, of the right shape and with values in range.

namespace fresco::dataset
{

/// Writes a file, whose folder must exist, whole or not at all.
FileStamp write_stamped(const std::filesystem::path& file, std::span<const std::byte> bytes);

/// The bytes of a file. Throws MissingInput if it is not there, Error if its size or its hash is another than the stamp's; both
/// name the file.
std::vector<std::byte> read_stamped(const std::filesystem::path& file, const FileStamp& stamp);

using fresco::to_npy;

/// The array as a raster. Throws Error naming `source` unless it is of T and of exactly this size (one channel: H x W).
template <class T>
Raster<T> raster_from(std::span<const std::byte> npy, int width, int height, int channels, std::string_view source);
/// A picture of any size up to 200 megapixels: uint8 H x W, H x W x 1, 3 or 4.
Raster8 picture_from(std::span<const std::byte> npy, std::string_view source);

/// Texcoords as round(65535 u) and back; clamped to [0,1].
Raster16 quantized(const RasterF& uv);
RasterF restored(const Raster16& uv);

/// Each throws Error naming `source`, the first pixel that is not as it must be, and what was expected: `valid` 0 or 1, and so
/// many ones; texcoords in [0,1] (1e-5 beyond is rounding), cosines in [0,1], depth finite and not negative, above 0 where
/// `valid`.
void check_valid(const Raster8& valid, std::int64_t ones, std::string_view source);
void check_uv(const RasterF& uv, std::string_view source);
void check_cosine(const RasterF& cosine, std::string_view source);
void check_depth(const RasterF& depth, const Raster8& valid, std::string_view source);

}  // namespace fresco::dataset

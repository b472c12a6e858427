#pragma once

#include <fresco/image.h>
#include <fresco/option_declaration.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

/// Element types of a NumPy array file that fresco reads and writes, little-endian, C order.
enum class NpyType
{
    uint8,
    uint16,
    uint32,
    int32,
    int64,
    float32,
    float64
};

struct NpyArray
{
    NpyType type = NpyType::uint8;
    std::vector<std::size_t> shape;
    std::vector<std::byte> bytes;

    std::size_t count() const;
    /// The elements, checked against `T`. Throws Error if the type is another.
    template <class T>
    std::span<const T> as() const;
};

/// Strict NPY reader (versions 1 to 3); Fortran order becomes C order. Throws Error naming `source` and the offset on a wrong
/// magic, an unknown type, a shape that does not fit the file's size, or bytes after the data.
NpyArray parse_npy(std::span<const std::byte> bytes, std::string_view source);
NpyArray read_npy(const std::filesystem::path& file);

FileFormat npy_format();

/// The file of an array. Throws Error unless `shape` asks for as many bytes of `type`.
std::vector<std::byte> to_npy(NpyType type, std::span<const std::size_t> shape, std::span<const std::byte> bytes);
/// H x W (one channel) or H x W x C, as all functions here that take rasters: of bytes, 16-bit numbers or floats.
template <class T>
std::vector<std::byte> to_npy(const Raster<T>& raster);
/// The reverse. Throws Error naming `source` unless the array is of T, H x W or H x W x C, and at most 2^20 pixels a side.
template <class T>
Raster<T> to_raster(const NpyArray& array, std::string_view source);

/// Writes whole or not at all.
template <class T>
void write_npy(const std::filesystem::path& file, const Raster<T>& raster);

}  // namespace fresco

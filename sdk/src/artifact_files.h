#pragma once

#include <fresco/artifact.h>
#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/value.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file What several artifacts share in their on-disk forms.

namespace fresco::detail
{

/// A JSON file of an artifact's folder: an entry by its name, or the whole. Throws Error naming the file.
class JsonFile
{
  public:
    explicit JsonFile(const std::filesystem::path& file);
    JsonFile(const JsonFile&) = delete;
    JsonFile& operator=(const JsonFile&) = delete;
    JsonPlace operator[](std::string_view key) const { return root_[key]; }
    const JsonPlace* operator->() const { return &root_; }

  private:
    Value value_;
    JsonPlace root_;
};

/// The part of `path` below `base`, or nothing.
std::optional<std::string> below(const std::filesystem::path& path, const std::filesystem::path& base);

/// Says by errno why a file or folder cannot be made. exFAT and its relatives only call an argument invalid: names the character
/// that they refuse.
std::string cause_of(int error, const std::filesystem::path& path);

/// A raster in less space, without loss: sdk/docs/packed_rasters.md says what each byte is. Throws Error naming `source` for more
/// than 2^28 pixels.
template <class T>
std::vector<std::byte> pack_raster(const Raster<T>& raster, std::string_view source);
/// The reverse. Throws Error naming `source` and the offset if the bytes are damaged or hold values of another type.
template <class T>
Raster<T> unpack_raster(std::span<const std::byte> file, std::string_view source);

/// As `<name>.packed` in an artifact's folder.
template <class T>
void write_packed(const std::filesystem::path& folder, const std::string& name, const Raster<T>& raster);
/// `<name>.npy` if a program wrote that, else `<name>.packed`.
std::filesystem::path npy_or_packed(const std::filesystem::path& folder, const std::string& name);
/// The raster of that file. Throws as read_raster and unpack_raster do.
template <class T>
Raster<T> read_npy_or_packed(const std::filesystem::path& folder, const std::string& name, int channels);

/// A raster of an NPY file. Throws Error naming the file if it is of another type or number of channels. `channels` 0: any from 1
/// to 4.
template <class T>
Raster<T> read_raster(const std::filesystem::path& file, int channels);

}  // namespace fresco::detail

#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>

namespace scan_mesh
{

/// A picture of a glTF file: one of the two.
struct GltfImage
{
    int buffer_view = -1;
    std::string uri;  ///< As in the file, also a "data:" URI.
};

/// What a glTF or GLB file holds. Every buffer view lies inside of its buffer.
struct GltfFile
{
    tinygltf::Model model;  ///< Without images, skins, animations, cameras and extras.
    std::vector<GltfImage> images;
};

/// Reads a file with tinygltf, once its JSON has been parsed strictly (at most 64 levels, no key twice) and reduced to what is
/// used. Buffers are read by this function, not by tinygltf: from the file's folder or below, or from the GLB itself; their files
/// are added to `files_read`. Throws Error naming the offset or the entry: anything but glTF 2, an extension that is required and
/// unknown, counts, types and ranges that are wrong. Does not name the file.
GltfFile load_gltf(const std::filesystem::path& file, std::vector<std::filesystem::path>& files_read);

/// The bytes of a view.
std::span<const unsigned char> view_bytes(const tinygltf::Model& model, std::size_t view);

/// The bytes of a "data:" URI. Throws Error beginning with `place` for any other kind than base64 of PNG or JPEG.
std::vector<std::byte> data_uri_bytes(const std::string& uri, const std::string& place);
bool is_data_uri(const std::string& uri);

/// A URI as a file name: %20 as a space.
std::string decoded_uri(std::string_view uri);

/// "accessors[3]: "
std::string entry(const char* list, std::size_t at);

}  // namespace scan_mesh

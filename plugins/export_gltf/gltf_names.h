#pragma once

#include <cstdint>

/// \file Numbers of glTF 2.0 that its writer and its reader share.
namespace gltf
{

inline constexpr std::uint32_t magic = 0x46546C67;  // "glTF"
inline constexpr std::uint32_t json_chunk = 0x4E4F534A;
inline constexpr std::uint32_t binary_chunk = 0x004E4942;

inline constexpr int array_buffer = 34962;
inline constexpr int element_array_buffer = 34963;
inline constexpr int int8 = 5120;
inline constexpr int uint16 = 5123;
inline constexpr int uint32 = 5125;
inline constexpr int float32 = 5126;
inline constexpr int triangles = 4;
inline constexpr int linear = 9729;
inline constexpr int linear_mipmap_linear = 9987;
inline constexpr int clamp_to_edge = 33071;

inline constexpr const char* unlit = "KHR_materials_unlit";
inline constexpr const char* quantization = "KHR_mesh_quantization";
inline constexpr const char* meshopt = "EXT_meshopt_compression";

}  // namespace gltf

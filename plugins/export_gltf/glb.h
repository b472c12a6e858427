#pragma once

#include <fresco/texturing/welded_mesh.h>
#include <fresco/value.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

inline constexpr const char* unlit_extension = "KHR_materials_unlit";
inline constexpr const char* quantization_extension = "KHR_mesh_quantization";

enum class GltfMaterial
{
    unlit,  ///< Shown as painted (KHR_materials_unlit).
    pbr     ///< Lit, rough, not metallic; with smooth normals.
};

struct GlbOptions
{
    GltfMaterial material;
    std::array<double, 4> turn;  ///< Unit quaternion (x, y, z, w) of the node; {0, 0, 0, 1}: not turned.
    std::string image_type;      ///< MIME type of the picture's bytes.
    bool quantize;               ///< KHR_mesh_quantization, see quantized_mesh.h.
    bool compress;               ///< EXT_meshopt_compression; the mesh should be in the order of order_for_compression.
    fresco::Value origin{fresco::Value::Map{}};  ///< asset.extras; empty: none.
};

/// A binary glTF 2.0 file of one mesh, with one picture unless `image` is empty. glTF's v runs downwards: 1 - v is written.
/// Indices take 16 bits where these suffice. Throws Error where the file would exceed glTF's 4 GiB, and for texcoords that
/// `quantize` cannot hold.
std::string make_glb(const fresco::texturing::WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options);

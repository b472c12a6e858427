#pragma once

#include <fresco/texturing/welded_mesh.h>

#include <cstddef>
#include <string>
#include <vector>

enum class GltfMaterial
{
    unlit,  ///< Shown as painted (KHR_materials_unlit).
    pbr     ///< Lit, rough, not metallic; with smooth normals.
};

/// Which axis of the mesh points up; glTF's is +Y.
enum class GltfUp
{
    keep,     ///< Positions and node as they are.
    z,        ///< The node is turned so that the mesh's +Z becomes +Y.
    minus_y,  ///< The node is turned so that the mesh's -Y becomes +Y.
};

struct GlbOptions
{
    GltfMaterial material = GltfMaterial::unlit;
    GltfUp up = GltfUp::keep;
    std::string image_type = "image/png";  ///< MIME type of the picture's bytes.
    bool quantize = false;                 ///< KHR_mesh_quantization, see quantized_mesh.h.
    bool compress = false;                 ///< EXT_meshopt_compression; the mesh should be in the order of order_for_compression.
};

/// A binary glTF 2.0 file of one mesh, with one picture unless `image` is empty. glTF's v runs downwards: 1 - v is written.
/// Indices take 16 bits where these suffice. Throws Error where the file would exceed glTF's 4 GiB, for texcoords that `quantize`
/// cannot hold, and for `compress` where can_compress() is false.
std::vector<std::byte> make_glb(const fresco::texturing::WeldedMesh& mesh, const std::vector<std::byte>& image,
                                const GlbOptions& options);

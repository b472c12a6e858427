#pragma once

#include <fresco/texturing/exports.h>
#include <fresco/value.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// \file Writes a mesh and its picture as binary glTF 2.0, optionally quantized and compressed. The stage calls make_glb(), after
/// order_for_compression() if it compresses, and has the bytes checked before it writes them (check_glb.h).

/// A mesh in integers, for KHR_mesh_quantization. Rows are padded to multiples of four bytes.
struct QuantizedMesh
{
    std::vector<std::array<std::uint16_t, 4>> positions;  ///< V: origin + step_m * (x, y, z); the fourth is 0.
    std::vector<std::array<std::int8_t, 4>> normals;      ///< V: 127 times the unit vector; the fourth is 0.
    std::vector<std::array<std::int8_t, 4>> tangents;     ///< V or empty: 127 times the unit vector, and 127 or -127.
    std::vector<std::array<std::uint16_t, 2>> texcoords;  ///< V: 65535 u, 65535 (1 - v): glTF's origin is the upper left.
    fresco::Vec3f origin;                                 ///< Lowest corner, meters.
    float step_m = 1;                                     ///< The same along all axes, so that normals stay normals.
};

/// Positions are off by at most step_m / 2 along each axis, and step_m is the longest side of the mesh's box / 65535 (rounded up
/// to a float); normals by 1/254 per component; texcoords by 1/131070. Throws Error for a texcoord more than 1e-5 outside [0,1].
QuantizedMesh quantized(const fresco::texturing::WeldedMesh& mesh);

/// Reorders triangles and vertices so that neighbors follow each other, which makes the streams smaller. The surface stays the
/// same.
void order_for_compression(fresco::texturing::WeldedMesh& mesh);

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
    std::array<double, 4> turn;  ///< Unit quaternion (x, y, z, w) of the node; {0, 0, 0, 1}: none.
    std::string image_type;      ///< MIME type of the picture's bytes.
    bool quantize;               ///< KHR_mesh_quantization, see quantized().
    bool compress;               ///< EXT_meshopt_compression; the mesh should be in the order of order_for_compression.
    fresco::Value origin{fresco::Value::Map{}};                  ///< asset.extras; empty: none.
    fresco::texturing::PictureEncoding::EncodedRelief relief{};  ///< Pictures of image_type, in the mesh's tangents; empty: none.
};

/// A binary glTF 2.0 file of one mesh, with one picture unless `image` is empty, and two more with a relief. glTF's v runs
/// downwards: 1 - v is written. Indices take 16 bits where these suffice. Throws Error for a file beyond glTF's 4 GiB, and for
/// texcoords that `quantize` cannot represent.
std::string make_glb(const fresco::texturing::WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options);

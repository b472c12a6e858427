#pragma once

#include <fresco/texturing/exports.h>
#include <fresco/value.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// \file Writes binary glTF 2.0.

namespace fresco::texturing
{

/// The file of a glTF document and its only buffer. Throws Error beyond glTF's 4 GiB.
std::string glb_of(const Value& document, std::string_view binary);

/// A GLB's asset.extras: how it was made, and the mesh's offset where it has one, of which the run is told.
Value origin_of(const Mesh& mesh, RunContext& run);

struct GlbOptions
{
    bool lit;  ///< Lit, rough, not metallic, with smooth normals; otherwise shown as painted (KHR_materials_unlit).
    std::array<double, 4> turn;               ///< Unit quaternion (x, y, z, w) of the node; {0, 0, 0, 1}: none.
    std::string image_type;                   ///< MIME type of the pictures' bytes.
    Value origin{Value::Map{}};               ///< asset.extras; empty: none.
    PictureEncoding::EncodedRelief relief{};  ///< Pictures in the mesh's tangents; empty: none.
};

/// A binary glTF 2.0 file of one mesh, with one picture unless `image` is empty, and two more with a relief. glTF's v runs
/// downwards: 1 - v is written. Indices take 16 bits where these suffice. Throws Error for a file beyond glTF's 4 GiB.
std::string make_glb(const WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options);

}  // namespace fresco::texturing

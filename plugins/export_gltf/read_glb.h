#pragma once

#include <fresco/math.h>
#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// A mesh with its picture as a viewer gets it from a file.
struct GlbModel
{
    std::vector<fresco::Vec3d> positions;  ///< V, as the node of the mesh places them, without the parent that turns it upright.
    std::vector<fresco::Vec3d> normals;    ///< V or empty; as stored, of about unit length.
    std::vector<fresco::Vec2d> texcoords;  ///< V or empty, glTF's: origin at the upper left.
    std::vector<fresco::Rgb8> colors;      ///< V or empty; sRGB.
    std::vector<std::uint32_t> indices;    ///< 3F, each < V.
    std::string image_type;                ///< MIME type; empty: there is no picture.
    std::vector<std::byte> image;
    fresco::Value origin;  ///< asset.extras; an empty map: none.
};

/// Reads a GLB of one mesh and at most one picture by the reader of `scan.mesh`, which shares nothing with the writer, and holds
/// everything in it against the specification: chunks and their lengths, views inside of their buffers, accessors inside of their
/// views and aligned, "min" and "max" against the values, indices in range, numbers finite, normals of unit length, extensions
/// that are required known and used ones declared, the picture's signature. Throws Error naming `source`, the offset or the
/// entry, and what was expected.
GlbModel read_glb(std::string_view file, std::string_view source);

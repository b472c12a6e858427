#pragma once

#include "glb.h"

#include <fresco/math.h>
#include <fresco/value.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// \file Checks a GLB before the stage writes it: reads it back, holds it against the specification and compares it with the
/// mesh.

/// A mesh with its picture, as a viewer reads them.
struct GlbModel
{
    std::vector<fresco::Vec3d>
        positions;  ///< V, transformed by the node of the mesh but not by its parent, which turns it upright.
    std::vector<fresco::Vec3d> normals;           ///< V or empty; as stored, of about unit length.
    std::vector<std::array<double, 4>> tangents;  ///< V or empty; as stored, of about unit length, and 1 or -1.
    std::vector<fresco::Vec2d> texcoords;         ///< V or empty, glTF's: origin at the upper left.
    std::vector<fresco::Rgb8> colors;             ///< V or empty; sRGB.
    std::vector<std::uint32_t> indices;           ///< 3F, each < V.
    std::string image_type;                       ///< MIME type; empty: no picture.
    std::vector<std::byte> image;
    std::vector<std::byte> normal_map;  ///< Empty, like the next: none.
    std::vector<std::byte> roughness_map;
    fresco::Value origin;  ///< asset.extras; an empty map: none.
};

/// Reads a GLB of one mesh and at most one material by the reader of `scan.mesh`, which is independent of the writer, and checks
/// it against the specification: chunks and their lengths, views inside of their buffers, accessors inside of their views and
/// aligned, "min" and "max" against the values, indices in range, numbers finite, normals and tangents of unit length, required
/// extensions known and used ones declared, the picture's signature. Throws Error naming `source`, the offset or the entry, and
/// what was expected.
GlbModel read_glb(std::string_view file, std::string_view source);

/// The largest differences between a file and its mesh.
struct GlbErrors
{
    double position_m = 0;  ///< Largest difference along an axis.
    double texcoord = 0;    ///< Largest difference of u or v.
};

/// Compares a file that was read back with the arguments of make_glb: the same triangles in the same order (corners may rotate
/// under compression), every position, normal, tangent and texcoord within the bounds of quantized() (bit by bit without
/// quantization), and the pictures' bytes. Throws Error naming the first difference.
GlbErrors check_glb(const GlbModel& model, const fresco::texturing::WeldedMesh& mesh, const std::vector<std::byte>& image,
                    const GlbOptions& options);

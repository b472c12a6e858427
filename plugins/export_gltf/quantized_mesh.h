#pragma once

#include <fresco/texturing/welded_mesh.h>

#include <array>
#include <cstdint>
#include <vector>

/// A mesh in whole numbers, as KHR_mesh_quantization allows. Rows are padded to multiples of four bytes.
struct QuantizedMesh
{
    std::vector<std::array<std::uint16_t, 4>> positions;  ///< V: origin + step_m * (x, y, z); the fourth is 0.
    std::vector<std::array<std::int8_t, 4>> normals;      ///< V: 127 times the unit vector; the fourth is 0.
    std::vector<std::array<std::uint16_t, 2>> texcoords;  ///< V: 65535 u, 65535 (1 - v): glTF's origin is the upper left.
    fresco::Vec3f origin;                                 ///< Lowest corner, meters.
    float step_m = 1;                                     ///< The same along all axes, so that normals stay normals.
};

/// Positions are off by step_m / 2 along each axis at most, and step_m is the longest side of the mesh's box / 65535 (rounded up
/// to a float); normals by 1/254 per component; texcoords by 1/131070. Throws Error for a texcoord more than 1e-5 outside [0,1].
QuantizedMesh quantized(const fresco::texturing::WeldedMesh& mesh);

#pragma once

#include <fresco/math.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// \file Parses the material files of OBJ models, for read_file_model(). Apart from it so that the fuzzer measures the parser.

namespace scan_mesh
{

/// A material of an MTL file: its color and its picture.
struct MtlMaterial
{
    std::string name;
    std::array<double, 3> color{1, 1, 1};  ///< Kd as written: displayed RGB, from 0 to 1 where it is valid.
    std::string picture;                   ///< The file name of map_Kd; empty: none.
    std::size_t picture_line = 0;
    fresco::Vec2d scale{1, 1};  ///< uv of the picture = scale * uv + offset.
    fresco::Vec2d offset;
    bool clamp = false;
};

/// Reads newmtl, Kd and map_Kd with its options -s, -o and -clamp; other statements and options are skipped. Throws Error naming
/// `source` and the line for an invalid color or option and for a statement before the first newmtl.
std::vector<MtlMaterial> parse_mtl(std::string_view text, std::string_view source);

}  // namespace scan_mesh

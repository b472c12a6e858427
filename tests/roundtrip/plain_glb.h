#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

/// \file Reads and draws what a viewer would, sharing no code and no convention with fresco: plain arrays, double precision.

namespace plain
{

using Point = std::array<double, 3>;

struct Corner
{
    Point position;
    double u = 0;  ///< Origin at the upper left, as glTF has it.
    double v = 0;
};

struct Model
{
    std::vector<std::array<Corner, 3>> triangles;
    std::vector<std::uint8_t> picture;  ///< The bytes of the embedded PNG.
};

/// A GLB of one mesh. Throws std::runtime_error for anything unexpected.
Model read_glb(const std::filesystem::path& file);

}  // namespace plain

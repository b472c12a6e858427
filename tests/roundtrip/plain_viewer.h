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

/// A pinhole camera as plain numbers: pixel (column, row) sees along ((column + 0.5 - cx) / fx, (row + 0.5 - cy) / fy, 1).
struct View
{
    int width = 0;
    int height = 0;
    double fx = 0, fy = 0, cx = 0, cy = 0;
    std::array<double, 12> world_from_camera{};  ///< 3 x 4, row-major.
};

struct Picture
{
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgb;
};

/// Mistakes of a viewer with another convention.
struct Wrong
{
    bool flipped_v = false;
    bool half_texel = false;     ///< Texel centers at whole numbers.
    bool mirrored_axis = false;  ///< Pixel columns from right to left.
};

struct Pixel
{
    bool found = false;
    Point position{};             ///< World.
    std::array<double, 3> rgb{};  ///< 0..255
};

/// The nearest triangle whose front (counter-clockwise corners) faces the camera or not, at every pixel center, row-major; a
/// pixel whose nearest triangle shows its back stays empty. Every triangle against every pixel, by 2D homogeneous coordinates.
std::vector<Pixel> render(const Model& model, const Picture& picture, const View& view, const Wrong& wrong);

}  // namespace plain

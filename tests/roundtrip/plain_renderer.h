#pragma once

#include "plain_glb.h"

#include <array>
#include <cstdint>
#include <vector>

namespace plain
{

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

/// What a viewer of another convention would do.
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

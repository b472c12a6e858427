#pragma once

#include "agreement.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>

#include <vector>

namespace fresco::inspect
{

/// A pixel of a color picture.
struct ColorSample
{
    float x = 0;  ///< Pixel coordinates.
    float y = 0;
    Rgb8 color{};
};

/// What is looked at of a frame.
struct View
{
    DepthView depth;                      ///< No samples: the frame has no depth picture; then its camera is the color camera.
    std::vector<DepthSample> silhouette;  ///< Of the depth picture, in its pixels.
    Intrinsics color;                     ///< At the size of `edges`.
    RasterF edges;                        ///< edge_strength; empty: the frame has no color picture.
    std::vector<ColorSample> colors;      ///< On a grid over the picture, of the size of `edges`.
};

/// The camera at another height of its picture; the width follows.
Camera at_height(const Camera& camera, int height);

/// Frame `index`: depths on a grid of 40 columns, silhouettes and edges at a height of 120 px, at which a tenth of a focal length
/// moves them by four pixels and a color camera that is not synchronized by one or two. Throws as check_camera, load_color and
/// load_depth do. Thread-safe.
View view_of(const Frames& frames, std::size_t index, const ImageIo& images);

}  // namespace fresco::inspect

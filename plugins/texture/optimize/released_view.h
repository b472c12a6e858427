#pragma once

/// \file A view as the released code of StyleMesh reads it from disk (its data/abstract_dataset.py and
/// scripts/scannet/prepare_data). Its losses compare with what is left of pictures and depth after several resamplings, so these
/// are followed bit by bit.

#include "levels.h"

#include <fresco/image.h>
#include <fresco/uv_maps.h>

#include <span>

namespace fresco::optimize
{

struct ReleasedView
{
    Raster8 picture;       ///< The camera's, RGB, of the smallest map's size.
    Raster<double> depth;  ///< Meters, of the smallest map's size; 0: the pixel takes part in nothing.
};

/// Pictures and depth of ScanNet are exported at 320 x 240 by nearest neighbor (fresco::exported_for_stylemesh) and loaded from
/// there; those of Matterport3D are loaded as they are. Loading resizes pictures by Pillow's bicubic filter in 8 bits, and depth
/// between pixels, where a hole is a depth of 0 m like any other. A pixel takes part if the largest map has surface there; on
/// ScanNet, only if its depth is above 0 in that map's size as well.
/// \param maps    ascending
/// \param camera  RGB as recorded
/// \param sensor  meters, 0: not measured; the depth camera's pixels count as the color camera's. Empty: the mesh's depth
/// \pre is_released(protocol)
ReleasedView released_view(std::span<const UvMap> maps, const Raster8& camera, const Raster<double>& sensor, Protocol protocol);

/// Pillow's Image.resize with its default filter: Keys' cubic convolution (a = -1/2), stretched by the factor of a reduction,
/// rows first, in fixed point with 22 bits, rounded to 8 bits after each pass.
Raster8 bicubic(const Raster8& picture, int width, int height);

}  // namespace fresco::optimize

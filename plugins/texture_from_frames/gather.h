#pragma once

#include "picture_pyramid.h"
#include "pixel_links.h"

#include <fresco/image.h>
#include <fresco/uv_maps.h>

#include <array>
#include <cstdint>
#include <vector>

namespace fresco::from_frames
{

/// What one view says about one texel.
struct TexelSample
{
    std::uint32_t texel = 0;  ///< row * size + column; row 0 is at the top (v = 1).
    float weight = 0;         ///< Above 0.
    std::array<float, 3> rgb{};
};

/// What a view says, each texel at most once; cut into blocks of whole texture rows, so that blocks can be worked on side by
/// side.
using SampleBlocks = std::vector<std::vector<TexelSample>>;

/// What surrounds the gathering of one view.
struct GatherTarget
{
    int size_px = 0;            ///< Texels a side.
    int rows_per_block = 0;     ///< Of SampleBlocks.
    bool between_only = false;  ///< Leave out texels that lie beside pixels rather than between them.
};

/// Looks up, for each texel that a view sees, the camera's picture. Each square of four neighboring pixel centers that show one
/// surface and one chart (or three of them) is drawn into the texture as two triangles (one), and every texel center inside them
/// knows by interpolation where in the picture it is. So texels between pixels are met however fine the texture is, the
/// picture's own resolution counts and not the map's, and texels that cover many pixels take their mean. A scatter of pixels
/// would leave holes in the first case and lose detail in the second.
///
/// At the rim of charts and pictures, where a pixel has no such squares around it, the texels of its bilinear footprint take its
/// color at a hundredth of its weight: it counts where no view looks properly, in atlases of tiny charts everywhere.
///
/// \param weight  H x W, what each pixel of the map counts; 0: not used, neither is what is between it and others
/// A texel that is met more than once keeps its heaviest sample, the first of equals.
SampleBlocks gather(const UvMap& map, const PixelLinks& links, const RasterF& weight, const PicturePyramid& picture,
                    const GatherTarget& target);

}  // namespace fresco::from_frames

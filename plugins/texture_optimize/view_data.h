#pragma once

#include "grid_mask.h"
#include "levels.h"
#include "view_source.h"

#include <fresco/torch/features.h>
#include <fresco/torch/texture_representation.h>

#include <torch/types.h>

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace fresco::optimize
{

/// One height of one view, ready for the consecutive steps on it.
struct LevelData
{
    int height_px = 0;
    std::unique_ptr<TextureView> view;
    LevelPixels pixels;
    RasterF factor;        ///< H x W: what the image gradient is multiplied by.
    double share = 0;      ///< ŵ_l
    torch::Tensor camera;  ///< 3 x H x W, RGB in [0,1].
    torch::Tensor all;     ///< H x W, bool.
    torch::Tensor fine;    ///< H x W, bool.

    /// What parts found out and the next step on this view needs again.
    std::map<const FeatureNetwork*, std::map<std::string, torch::Tensor>> camera_features;
    std::map<std::tuple<int, bool>, GridMask> grids;  ///< By stride, and whether of the fine pixels.
};

struct ViewData
{
    std::size_t view = 0;
    std::vector<LevelData> levels;  ///< Those with pixels, smallest height first.
    std::vector<int> numbers;       ///< Of each level: its index in the render pyramid.
};

/// Reads a view's uv maps and camera picture. On any thread.
std::unique_ptr<ViewData> load_view(const ViewSource& source, std::size_t view, const TextureRepresentation& texture,
                                    bool scale_by_angle);

/// Moves what losses see to `device`.
void move_to(ViewData& data, const torch::Device& device);

}  // namespace fresco::optimize

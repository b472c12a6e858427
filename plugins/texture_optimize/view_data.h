#pragma once

#include "crops.h"
#include "gradient_union.h"
#include "grid_mask.h"
#include "levels.h"
#include "view_source.h"

#include <fresco/torch/loss.h>
#include <fresco/torch/texture_representation.h>

#include <torch/types.h>

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace fresco::optimize
{

/// Which pixels of a view belong to which height, and what losses see of them.
struct LevelRules
{
    enum class Depth
    {
        mesh,             ///< The uv maps' own.
        sensor,           ///< The depth camera's; pixels it has not measured belong to no level …
        sensor_or_lowest  ///< … or to the lowest height.
    };

    bool by_depth;  ///< Depth levels; else every height shows every pixel.
    Depth depth;
    DepthRule depth_rule;
    AngleRule angle;
    GradientScaling scaling;
    bool share_by_features;        ///< ŵ_l from the masks on each layer's grid; else from pixels.
    bool enlarge_camera_features;  ///< The camera is encoded at the smallest height and its features enlarged.
    bool fill_with_corner;         ///< Pixels without a surface show the texture's first texel; else black.
};

/// Features by network and layer.
using FeatureMaps = std::map<const FeatureNetwork*, std::map<std::string, torch::Tensor>>;

/// The camera picture at the smallest height, and its features, for all levels of a view.
struct SmallestCamera
{
    torch::Tensor picture;  ///< 3 x H x W, RGB in [0,1].
    FeatureMaps features;
};

/// The parts of a level that a network encodes where losses read only selected features.
struct CroppedLevel
{
    std::vector<Crop> crops;
    std::vector<std::map<std::string, torch::Tensor>> camera_features;  ///< Per crop: C x N, of its core's cells.
    std::vector<std::map<std::tuple<int, Pixels>, GridMask>> grids;     ///< Per crop: its core's cells, in its own grid.
};

/// One height of one view, ready for the consecutive steps on it.
struct LevelData
{
    int height_px = 0;
    std::unique_ptr<TextureView> view;
    Raster8 valid;  ///< H x W: 1 = the texture is seen here, whether or not the pixel belongs to the level.
    LevelPixels pixels;
    RasterF factor;                            ///< H x W: what the image gradient is multiplied by.
    double share = 0;                          ///< ŵ_l
    torch::Tensor camera;                      ///< 3 x H x W, RGB in [0,1].
    torch::Tensor all;                         ///< H x W, bool.
    torch::Tensor fine;                        ///< H x W, bool.
    std::shared_ptr<SmallestCamera> smallest;  ///< Null: the camera is encoded at this height.

    /// What parts found out and the next step on this view needs again.
    FeatureMaps camera_features;
    std::map<std::tuple<int, Pixels>, GridMask> grids;  ///< By stride and pixels.
    std::map<const FeatureNetwork*, CroppedLevel> cropped;
    std::map<std::pair<const FeatureNetwork*, int>, FineColumns> fine_columns;  ///< By network and stride.

    /// Where the texture is not on the CPU: `valid` (bool) and `factor` beside it.
    torch::Tensor valid_there;
    torch::Tensor factor_there;
};

struct ViewData
{
    std::size_t view = 0;
    std::vector<LevelData> levels;  ///< Those with pixels, smallest height first.
    std::vector<int> numbers;       ///< Of each level: its index in the render pyramid.
    bool share_by_features = false;
    GradientUnion gradient_union;
};

/// Reads a view's uv maps and camera picture. On any thread.
std::unique_ptr<ViewData> load_view(const ViewSource& source, std::size_t view, const TextureRepresentation& texture,
                                    const LevelRules& rules);

/// The mask of the level's `pixels`.
Raster8 chosen_pixels(const LevelPixels& level, Pixels pixels);

/// The cells of a grid of `stride` that belong to the level's `pixels`; made when first asked for.
const GridMask& grid_of(LevelData& level, int stride, Pixels pixels, const torch::Device& device);

/// Forgets what networks say of the camera picture.
void forget_camera(ViewData& data);

/// Moves what losses see to `device`; with `texture_too` what the lookup needs beside the view as well.
void move_to(ViewData& data, const torch::Device& device, bool texture_too);

}  // namespace fresco::optimize

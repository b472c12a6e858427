#pragma once

#include "best_samples.h"
#include "exposure.h"
#include "view_weights.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace fresco::from_frames
{

/// One view as it is read.
struct View
{
    UvMap map;
    Camera camera;     ///< The color camera at full size.
    Raster8 picture;   ///< RGB, the camera's whole view at any size.
    RasterF measured;  ///< Of the map's size: measured depth in meters, 0 = none; empty: no depth picture, or not wanted.
    std::string sequence;
};

/// Reads view i. Called from several threads, twice for each view.
using ViewReader = std::function<View(std::size_t)>;

struct TextureRules
{
    int size_px;
    int views_count;  ///< Per texel, 1 to 63.
    bool solve_exposure;
    double sharpness_power;
    WeightRules weights;
    BlendRules blend;
};

struct FramesTexture
{
    RasterF picture;                   ///< S x S x 3, RGB in [0,1]; unseen texels continue the seen ones smoothly.
    Raster8 seen;                      ///< S x S: 1 = some view shows it.
    std::vector<Gain> gains;           ///< Per view.
    std::vector<double> sharpness;     ///< Per view: what its weights were multiplied by.
    std::size_t blended_samples = 0;   ///< Over all texels.
    std::size_t rejected_samples = 0;  ///< Of these, as outliers.
    std::size_t pixels = 0;            ///< Valid in the uv maps, …
    std::size_t edge_pixels = 0;       ///< … of these beside a depth step …
    std::size_t occluded_pixels = 0;   ///< … and rejected for their measured depth.
};

/// The texture that `count` views show. Reads them twice, as many at a time as there are threads; memory does
/// not grow with their number except for 100 kB a view and the N x N equations of the exposures. The same bytes for any number of
/// threads. Throws Error if no view shows a texel, Canceled, and what `read` throws.
FramesTexture frames_texture(std::size_t count, const ViewReader& read, const TextureRules& rules, Progress& progress);

/// What each view's weights are multiplied by: its sharpness over the median of the views of its sequence from four before to
/// four after it, to the given power, within [0.1, 4]. Pictures of one surface from about one place are compared so; the
/// sharpness of others says more about what they show. `sequences`: per view.
std::vector<double> sharpness_factors(const std::vector<double>& sharpness, const std::vector<std::string>& sequences,
                                      double power);

}  // namespace fresco::from_frames

#pragma once

/// \file The texture before the first step (option `init`). For loop.cpp.

#include "views.h"

#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <cstdint>
#include <vector>

namespace fresco::optimize
{

/// Start of the texture: displayed RGB in [0,1].
struct InitialTexture
{
    RasterF picture;  ///< S x S x 3; empty where the texture begins at zero.
    Raster8 seen;     ///< S x S: 1 = in the bilinear footprint of some view's pixel.
};

/// Option `init`, under the same names.
enum class Init
{
    frames,
    zeros,
    color,
    noise
};

struct InitialRules
{
    Init init;
    int size_px = 0;
    std::uint64_t seed = 0;          ///< Seed of the noise.
    const Texture* start = nullptr;  ///< With `frames`: taken instead of gathering. Of the same atlas as the maps.
    bool start_is_shown = false;     ///< By frames without pictures: then it may be there with any `init`.

    /// Throws Error if the start texture does not hold displayed, finite colors, if nothing of it was seen, and if it is given
    /// with another `init` and no frame shows it.
    void check() const;
};

/// `color` is the mean of `style`, `noise` has its mean and deviation, `frames` are camera colors, recolored to the style by
/// the linear Monge-Kantorovich map and filled in where no view looks: gathered through the uv maps of the largest height, or
/// those of the start texture where it was seen, in any size. Reads every view once, a few at a time. `style`: RGB in [0,1]. The
/// same bytes for any number of threads. Throws Error as rules.check().
InitialTexture initial_texture(const ViewSource& source, const std::vector<std::size_t>& views, const RasterF& style,
                               const InitialRules& rules, Progress& progress);

}  // namespace fresco::optimize

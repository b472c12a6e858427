#pragma once

#include "patches.h"
#include "picture_level.h"

#include <cstdint>
#include <span>
#include <vector>

namespace fresco::synthesize
{

/// Where in the picture the look of a patch was found.
struct Match
{
    Vec2f at;            ///< Of the patch's center, in the level's picture.
    float distance = 0;  ///< Mean squared difference of a value of L*a*b*.
    Vec2f turn{1, 0};    ///< Which way the patch's x axis runs there, unit length.

    /// Of a point of the patch, `offset` from its center.
    Vec2f place(Vec2f offset) const { return at + turned(offset, turn); }
};

struct SearchOptions
{
    double completeness;  ///< α in L*a*b*² per value: the smaller, the more evenly the picture is used.
    double stroke_px;     ///< How wide a stroke is, in texels and in pixels of the level's picture.
    double variety;       ///< What places of the surface prefer, see Variety; L*a*b*² per value.
    double lift;          ///< Added to all distances: makes completeness count where much fits well. L*a*b*² per value.
    std::uint32_t seed;   ///< Of the preferences.
};

/// The best place of the picture for every patch: an exact search over the keys by principal components; then, by all values,
/// the best position between the key found and the next ones; then the places that continue what the patches around found, which
/// may differ more (coherence; Ashikhmin 2001, Hertzmann et al. 2001). A place costs w (d + lift) + preference, where w is the
/// key's completeness and price, 1 on average. In a picture with directions, keys are turned so that strokes run along x; a place
/// that continues another keeps its turn on the surface, and costs more the more its strokes are out of line. `wanted`: per
/// texel, L*a*b*. `crowding`: per key, see update_crowding. The same for any number of threads. Throws Canceled.
std::vector<Match> search(const Patches& patches, const SurfaceGrid& grid, std::span<const Vec3f> wanted,
                          const PictureLevel& picture, const SearchOptions& options, std::span<const float> crowding,
                          const Progress& progress);

}  // namespace fresco::synthesize

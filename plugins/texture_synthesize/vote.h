#pragma once

#include "search.h"

#include <cstddef>
#include <span>

namespace fresco::synthesize
{

/// The weight of a patch in the mean: a Gaussian window (σ = 0.35 sides, falling to 0 at its border) times how well it fits
/// (Kwatra et al. 2005).
float vote_weight(Vec2f offset, float side, float distance);

/// The mixed color of a point and the patch that counts most; `color(patch's match, offset)` gives each patch's own.
struct Vote
{
    Vec3f color;
    Cover heaviest;
    Vec2f heaviest_offset;
};

/// `heaviest_share`: how much of the color is the heaviest patch's own; the rest is the mean of all. `shift(patch)`: from the
/// covered texel's center to the point, in texels of that patch's plane.
template <class Shift, class Color>
Vote vote(std::span<const Cover> covers, std::span<const Match> matches, int side, float heaviest_share, const Shift& shift,
          const Color& color)
{
    Vote result;
    Vec3f sum;
    Vec3f heaviest_color;
    float total = 0;
    float most = -1;
    for (const Cover& cover : covers)
    {
        const Match& match = matches[cover.patch];
        const Vec2f offset = cover.offset() + shift(cover.patch);
        const float weight = vote_weight(offset, static_cast<float>(side), match.distance);
        if (weight <= 0 && most >= 0)
            continue;
        const Vec3f own = color(match.at + offset);
        sum += own * weight;
        total += weight;
        if (weight > most)
        {
            most = weight;
            heaviest_color = own;
            result.heaviest = cover;
            result.heaviest_offset = offset;
        }
    }
    result.color = total > 0 ? sum * ((1 - heaviest_share) / total) + heaviest_color * heaviest_share : heaviest_color;
    return result;
}

}  // namespace fresco::synthesize

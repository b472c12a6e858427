#pragma once

#include "search.h"

#include <cstddef>
#include <span>

namespace fresco::synthesize
{

/// The weight of a patch in the mean: a Gaussian window (σ = 0.35 sides, falling to 0 at its border) times how well it fits
/// (Kwatra et al. 2005).
float vote_weight(Vec2f offset, float side, float distance);

/// What the patches over a point say of its color.
struct Vote
{
    Vec3f mean;           ///< By weight.
    Vec3f heaviest;       ///< The color of the patch that counts most, …
    std::uint32_t patch;  ///< … this patch …
    Vec2f offset;         ///< … and where the point lies on it, in texels from its center.
};

/// `shift(patch)`: from the covered texel's center to the point, in texels of that patch's plane. `color(place in the picture)`.
template <class Shift, class Color>
Vote vote(std::span<const Cover> covers, std::span<const Match> matches, int side, const Shift& shift, const Color& color)
{
    Vote result{};
    Vec3f sum;
    float total = 0;
    float most = -1;
    for (const Cover& cover : covers)
    {
        const Match& match = matches[cover.patch];
        const Vec2f offset = cover.offset() + shift(cover.patch);
        const float weight = vote_weight(offset, static_cast<float>(side), match.distance);
        if (weight <= 0 && most >= 0)
            continue;
        const Vec3f own = color(match.place(offset));
        sum += own * weight;
        total += weight;
        if (weight > most)
        {
            most = weight;
            result.heaviest = own;
            result.patch = cover.patch;
            result.offset = offset;
        }
    }
    result.mean = total > 0 ? sum * (1 / total) : result.heaviest;
    return result;
}

}  // namespace fresco::synthesize

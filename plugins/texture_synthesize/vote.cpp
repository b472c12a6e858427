#include "vote.h"

#include <algorithm>
#include <cmath>

namespace fresco::synthesize
{
namespace
{

constexpr float vote_sigma = 0.35F;  // Of a side.
constexpr float epsilon = 1;         // L*a*b*²: patches that fit better than this count alike.
constexpr float power = -0.6F;

/// 1 in the middle of a patch, 0 from its border on, smooth between.
float to_border(float at, float side)
{
    const float t = std::clamp(4 * (0.5F - std::abs(at) / side), 0.0F, 1.0F);
    return t * t * (3 - 2 * t);
}

}  // namespace

float vote_weight(Vec2f offset, float side, float distance)
{
    const float gauss = std::exp(-dot(offset, offset) / (2 * vote_sigma * vote_sigma * side * side));
    return gauss * to_border(offset.x, side) * to_border(offset.y, side) * std::pow(distance + epsilon, power);
}

}  // namespace fresco::synthesize

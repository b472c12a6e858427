#pragma once

#include <fresco/math.h>

#include <algorithm>
#include <cmath>

namespace fresco
{

/// What lab_from_rgb converts, back; colors outside the gamut are clamped to [0,1].
inline Vec3f rgb_from_lab(Vec3f lab)
{
    const auto curve_back = [](float f)
    {
        const float cube = f * f * f;
        return cube > 216.0F / 24389.0F ? cube : (116 * f - 16) / (24389.0F / 27.0F);
    };
    const auto displayed = [](float light)
    {
        const float v = light <= 0.0031308F ? 12.92F * light : 1.055F * std::pow(light, 1 / 2.4F) - 0.055F;
        return std::clamp(v, 0.0F, 1.0F);
    };
    const float fy = (lab.x + 16) / 116;
    const float x = 0.950456F * curve_back(fy + lab.y / 500);
    const float y = curve_back(fy);
    const float z = 1.088754F * curve_back(fy - lab.z / 200);
    return {displayed(3.240479F * x - 1.537150F * y - 0.498535F * z), displayed(-0.969256F * x + 1.875992F * y + 0.041556F * z),
            displayed(0.055648F * x - 0.204043F * y + 1.057311F * z)};
}

}  // namespace fresco

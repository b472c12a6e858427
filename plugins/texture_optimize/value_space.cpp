#include "value_space.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace fresco::optimize
{
namespace
{
/// Of red, green and blue.
constexpr std::array<float, 3> network_mean{123.68F, 116.779F, 103.939F};
}  // namespace

std::pair<double, double> ValueSpace::stored_range() const
{
    if (!network_)
        return {0, 1};
    return {-static_cast<double>(network_mean[0]), 255 - static_cast<double>(network_mean[2])};
}

float ValueSpace::offset(std::size_t channel) const
{
    return network_ ? network_mean.at(channel) : 0.0F;
}

float ValueSpace::shown(float stored, std::size_t channel) const
{
    return network_ ? (stored + network_mean[channel]) / 255 : stored;
}

void ValueSpace::display(std::span<const float> stored, std::span<const std::uint8_t> valid, std::span<float> displayed) const
{
    const std::size_t pixels = valid.size();
    const float least = clamped_ ? 0.0F : -std::numeric_limits<float>::infinity();
    const float most = clamped_ ? 1.0F : std::numeric_limits<float>::infinity();
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < pixels; ++i)
            displayed[c * pixels + i] =
                valid[i] != 0 ? std::clamp(shown(stored[plane_of(c) * pixels + i], c), least, most) : 0.0F;
}

void ValueSpace::back(std::span<const float> stored, std::span<const float> factor, std::span<float> gradient) const
{
    const std::size_t pixels = factor.size();
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < pixels; ++i)
        {
            const float value = shown(stored[plane_of(c) * pixels + i], c);
            float& g = gradient[c * pixels + i];
            const bool leads_on = clamped_ && ((value < 0 && g > 0) || (value > 1 && g < 0));
            g = leads_on ? 0.0F : g * (factor[i] * scale());
        }
    if (network_)
        std::swap_ranges(gradient.begin(), gradient.begin() + static_cast<std::ptrdiff_t>(pixels),
                         gradient.begin() + static_cast<std::ptrdiff_t>(2 * pixels));
}

void ValueSpace::store(RasterF& picture) const
{
    if (!network_)
        return;
    for (std::size_t i = 0; i + 2 < picture.values.size(); i += 3)
    {
        std::swap(picture.values[i], picture.values[i + 2]);
        for (std::size_t k = 0; k < 3; ++k)
            picture.values[i + k] = picture.values[i + k] * 255 - network_mean[2 - k];
    }
}

}  // namespace fresco::optimize

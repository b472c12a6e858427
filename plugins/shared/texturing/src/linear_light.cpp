#include <fresco/texturing/linear_light.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace fresco::texturing
{
namespace
{

double curve(double display)
{
    return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}

/// Light at each step, or half-way to the next.
template <std::size_t Count>
std::array<double, Count> lights(double shift)
{
    std::array<double, Count> result;
    for (std::size_t i = 0; i < Count; ++i)
        result[i] = curve((static_cast<double>(i) + shift) / 255);
    return result;
}

}  // namespace

double to_linear(std::uint8_t step)
{
    static const auto table = lights<256>(0);
    return table[step];
}

std::uint8_t from_linear(double light)
{
    static const auto borders = lights<255>(0.5);
    // How many borders are below each of evenly spaced lights: at most a few more are to be passed.
    constexpr std::size_t starts_count = 1024;
    static const auto starts = []
    {
        std::array<std::uint8_t, starts_count + 1> result;
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = static_cast<std::uint8_t>(std::ranges::upper_bound(borders, static_cast<double>(i) / starts_count) -
                                                  borders.begin());
        return result;
    }();
    std::size_t step = starts[static_cast<std::size_t>(std::clamp(light, 0.0, 1.0) * starts_count)];
    while (step < borders.size() && borders[step] <= light)
        ++step;
    return static_cast<std::uint8_t>(step);
}

double displayed(double light)
{
    const double inside = std::clamp(light, 0.0, 1.0);
    return inside <= 0.0031308 ? 12.92 * inside : 1.055 * std::pow(inside, 1 / 2.4) - 0.055;
}

}  // namespace fresco::texturing

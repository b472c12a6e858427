#include <fresco/images/lab.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco
{
namespace
{

constexpr float white_x = 0.950456F;
constexpr float white_z = 1.088754F;
constexpr float curve_end = 216.0F / 24389.0F;  // Below, the cube root gives way to a line.
constexpr float slope = 24389.0F / 27.0F;

float linear(float step)
{
    return step <= 0.04045F ? step / 12.92F : std::pow((step + 0.055F) / 1.055F, 2.4F);
}

float displayed(float light)
{
    const float v = light <= 0.0031308F ? 12.92F * light : 1.055F * std::pow(light, 1 / 2.4F) - 0.055F;
    return std::clamp(v, 0.0F, 1.0F);
}

float curve(float t)
{
    return t > curve_end ? std::cbrt(t) : (slope * t + 16) / 116;
}

float curve_back(float f)
{
    const float cube = f * f * f;
    return cube > curve_end ? cube : (116 * f - 16) / slope;
}

Vec3f lab_from_linear(float r, float g, float b)
{
    const float fx = curve((0.412453F * r + 0.357580F * g + 0.180423F * b) / white_x);
    const float fy = curve(0.212671F * r + 0.715160F * g + 0.072169F * b);
    const float fz = curve((0.019334F * r + 0.119193F * g + 0.950227F * b) / white_z);
    return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

}  // namespace

Vec3f lab_from_rgb(Vec3f rgb)
{
    const auto light = [](float step) { return linear(std::clamp(step, 0.0F, 1.0F)); };
    return lab_from_linear(light(rgb.x), light(rgb.y), light(rgb.z));
}

Vec3f rgb_from_lab(Vec3f lab)
{
    const float fy = (lab.x + 16) / 116;
    const float x = white_x * curve_back(fy + lab.y / 500);
    const float y = curve_back(fy);
    const float z = white_z * curve_back(fy - lab.z / 200);
    return {displayed(3.240479F * x - 1.537150F * y - 0.498535F * z), displayed(-0.969256F * x + 1.875992F * y + 0.041556F * z),
            displayed(0.055648F * x - 0.204043F * y + 1.057311F * z)};
}

RasterF lab_picture(const Raster8& rgb)
{
    std::array<float, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i)
        light[i] = linear(static_cast<float>(i) / 255);
    RasterF lab(rgb.width, rgb.height, 3);
    for (std::size_t i = 0; i + 2 < rgb.values.size(); i += 3)
    {
        const Vec3f color = lab_from_linear(light[rgb.values[i]], light[rgb.values[i + 1]], light[rgb.values[i + 2]]);
        lab.values[i] = color.x;
        lab.values[i + 1] = color.y;
        lab.values[i + 2] = color.z;
    }
    return lab;
}

}  // namespace fresco

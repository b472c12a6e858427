#include <fresco/images/recoloring.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace fresco
{
namespace
{

/// A color counts for those within this distance, in L*a*b*, the less the farther away it is.
constexpr double reach = 20;
/// A picture has enough of a color if this share of it has it, so weighed: a square of 7 cm in a painting of a square meter.
constexpr double enough = 0.005;
/// Steps of the grid over RGB.
constexpr int steps = 16;
constexpr std::size_t nodes = steps + 1;

struct Shade
{
    Vec3d color;
    double share = 0;
};

/// The picture's colors in cells of RGB, in L*a*b*.
std::vector<Shade> shades_of(const Raster8& picture, std::span<const std::uint8_t> opaque, ColorMoments& moments)
{
    std::map<std::array<int, 3>, Shade> cells;
    for (std::size_t pixel = 0; 3 * pixel < picture.values.size(); ++pixel)
    {
        if (!opaque.empty() && opaque[pixel] == 0)
            continue;
        const std::uint8_t* rgb = &picture.values[3 * pixel];
        const Vec3d color = Vec3d{double(rgb[0]), double(rgb[1]), double(rgb[2])} * (1.0 / 255);
        moments.add(color);
        Shade& shade = cells[{rgb[0] / steps, rgb[1] / steps, rgb[2] / steps}];
        shade.color += color;
        ++shade.share;
    }
    std::vector<Shade> shades;
    shades.reserve(cells.size());
    for (const auto& [cell, shade] : cells)
        shades.push_back({vec_cast<double>(lab_from_rgb(vec_cast<float>(shade.color * (1 / shade.share)))),
                          shade.share / static_cast<double>(moments.count())});
    return shades;
}

/// The weighted mean of the shades within a distance, and the sum of their weights.
Shade near(const std::vector<Shade>& shades, Vec3d lab, double distance)
{
    Shade sum;
    for (const Shade& shade : shades)
    {
        const Vec3d away = shade.color - lab;
        const double nearness = 1 - dot(away, away) / (distance * distance);
        if (nearness <= 0)
            continue;
        const double weight = shade.share * nearness * nearness;
        sum.color += shade.color * weight;
        sum.share += weight;
    }
    if (sum.share > 0)
        sum.color = sum.color * (1 / sum.share);
    return sum;
}

Vec3d move_of(const std::vector<Shade>& shades, Vec3d lab)
{
    double distance = reach;
    const double has = near(shades, lab, distance).share / enough;
    if (has >= 1 || shades.empty())
        return {};
    Shade found;
    while (found.share < enough)
        found = near(shades, lab, distance *= 1.06);
    return (found.color - lab) * (1 - has);
}

}  // namespace

Recoloring::Recoloring(const ColorMoments& from, const Raster8& picture, std::span<const std::uint8_t> opaque)
{
    ColorMoments to;
    const std::vector<Shade> shades = shades_of(picture, opaque, to);
    map_ = monge_kantorovich(from, to);
    for (std::size_t blue = 0; blue < nodes; ++blue)
        for (std::size_t green = 0; green < nodes; ++green)
            for (std::size_t red = 0; red < nodes; ++red)
            {
                const Vec3f rgb = Vec3f{float(red), float(green), float(blue)} * (1.0F / steps);
                moves_.push_back(vec_cast<float>(move_of(shades, vec_cast<double>(lab_from_rgb(rgb)))));
            }
}

Vec3f Recoloring::operator()(Vec3f rgb) const
{
    const Vec3d mapped = map_(vec_cast<double>(rgb));
    const auto clamped = [](double value) { return static_cast<float>(std::clamp(value, 0.0, 1.0)); };
    const Vec3f color{clamped(mapped.x), clamped(mapped.y), clamped(mapped.z)};
    const Vec3f at = color * steps;
    const auto below = [](float value) { return std::min(static_cast<std::size_t>(value), nodes - 2); };
    const std::size_t red = below(at.x), green = below(at.y), blue = below(at.z);
    const auto between = [](const Vec3f& a, const Vec3f& b, float share) { return a + (b - a) * share; };
    const auto along_red = [&](std::size_t up, std::size_t over)
    {
        const Vec3f* node = &moves_[((blue + over) * nodes + green + up) * nodes + red];
        return between(node[0], node[1], at.x - static_cast<float>(red));
    };
    const float up = at.y - static_cast<float>(green), over = at.z - static_cast<float>(blue);
    const Vec3f move =
        between(between(along_red(0, 0), along_red(1, 0), up), between(along_red(0, 1), along_red(1, 1), up), over);
    return dot(move, move) == 0 ? color : rgb_from_lab(lab_from_rgb(color) + move);
}

}  // namespace fresco

#include <fresco/geometry/atlas_figures.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace fresco::geometry
{
namespace
{

using Rgb = std::array<double, 3>;

constexpr Rgb background{24, 24, 28};
/// Points per pixel and direction.
constexpr int samples = 3;

/// Hues a golden section apart, so that numbers near each other differ most; two brightnesses and two saturations in turn.
Rgb color_of(std::uint32_t chart)
{
    const double hue = std::fmod(0.618033988749895 * chart, 1.0) * 6;
    const double brightness = chart % 2 == 0 ? 245 : 190;
    const double saturation = chart % 4 < 2 ? 0.75 : 0.5;
    Rgb color{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        const double away = std::abs(std::fmod(hue + 6 - 2 * static_cast<double>(k), 6.0) - 3);
        color[k] = brightness * (1 - saturation * (1 - std::clamp(away - 1, 0.0, 1.0)));
    }
    return color;
}

constexpr std::size_t faces_between_reports = 16384;
constexpr int rows_between_checks = 64;

/// Calls paint(x, y, face) for the middle of every cell of a grid of side x side, row 0 at v = 1, that a face covers.
template <class Paint>
void for_each_covered(const Mesh& mesh, int side, const Progress* progress, Paint paint)
{
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        if (progress != nullptr && f % faces_between_reports == 0)
            progress->check_canceled();
        std::array<Vec2d, 3> t;
        for (std::size_t k = 0; k < 3; ++k)
            t[k] = Vec2d{mesh.texcoords[3 * f + k].x, 1.0 - mesh.texcoords[3 * f + k].y} * static_cast<double>(side);
        const auto [low, high] = std::minmax({t[0].y, t[1].y, t[2].y});
        if (low >= side || high <= 0)
            continue;
        const double last = std::min(high, static_cast<double>(side));
        for (int y = static_cast<int>(std::ceil(std::max(low - 0.5, 0.0))); y + 0.5 < last; ++y)
        {
            if (progress != nullptr && y % rows_between_checks == 0)
                progress->check_canceled();
            double left = side;
            double right = 0;
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto a = t[k];
                const auto b = t[(k + 1) % 3];
                if ((a.y <= y + 0.5) == (b.y <= y + 0.5))
                    continue;
                const double x = a.x + (b.x - a.x) * ((y + 0.5 - a.y) / (b.y - a.y));
                left = std::min(left, x);
                right = std::max(right, x);
            }
            for (int x = static_cast<int>(std::ceil(std::max(left - 0.5, 0.0))); x + 0.5 < right && x < side; ++x)
                paint(x, y, f);
        }
    }
}

}  // namespace

Raster8 atlas_picture(const Mesh& mesh, int size_px, const Progress* progress)
{
    const auto charts = texcoord_charts(mesh);
    // Sums of what covers a pixel, and how many of its points are covered: at most once each in an atlas without overlaps.
    Raster<float> sums(size_px, size_px, 4);
    std::vector<Rgb> colors;
    for (const auto chart : charts)
        while (colors.size() <= chart)
            colors.push_back(color_of(static_cast<std::uint32_t>(colors.size())));
    for_each_covered(mesh, size_px * samples, progress,
                     [&](int x, int y, std::size_t face)
                     {
                         const auto& color = colors[charts[face]];
                         for (int k = 0; k < 3; ++k)
                             sums.at(x / samples, y / samples, k) += static_cast<float>(color[static_cast<std::size_t>(k)]);
                         sums.at(x / samples, y / samples, 3) += 1;
                     });
    Raster8 picture(size_px, size_px, 3);
    for (int y = 0; y < size_px; ++y)
        for (int x = 0; x < size_px; ++x)
        {
            const double covered = static_cast<double>(sums.at(x, y, 3));
            const double points = std::max(covered, static_cast<double>(samples * samples));
            for (int k = 0; k < 3; ++k)
                picture.at(x, y, k) = static_cast<std::uint8_t>(std::lround(
                    (static_cast<double>(sums.at(x, y, k)) + (points - covered) * background[static_cast<std::size_t>(k)]) /
                    points));
        }
    return picture;
}

}  // namespace fresco::geometry

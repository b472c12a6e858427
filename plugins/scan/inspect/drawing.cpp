#include "drawing.h"

#include <fresco/math.h>

#include <algorithm>
#include <cmath>

namespace fresco::inspect
{
namespace
{

constexpr int gap = 4;
constexpr Rgb8 background{32, 32, 36};
constexpr Rgb8 nothing{90, 90, 100};
constexpr Rgb8 as_recorded{255, 40, 40};
constexpr Rgb8 as_suggested{40, 255, 80};

Rgb8 gray(double level)
{
    const auto value = static_cast<std::uint8_t>(std::lround(255 * std::clamp(level, 0.0, 1.0)));
    return {value, value, value};
}

Rgb8 depth_color(double depth, double nearest)
{
    return depth > 0 ? gray(nearest / depth) : nothing;
}

Rgb8 difference_color(double mesh, double measured)
{
    if (measured <= 0 || mesh <= 0)
        return nothing;
    const double difference = mesh / measured - 1;
    const double rest = 1 - std::clamp((std::abs(difference) - 0.01) / 0.09, 0.0, 1.0);
    const auto value = static_cast<std::uint8_t>(std::lround(255 * rest));
    return difference < 0 ? Rgb8{255, value, value} : Rgb8{value, value, 255};
}

/// Depth nearer than all but a fiftieth: the lightest shade.
double nearest_of(const RasterF& depth)
{
    std::vector<float> found;
    for (const float value : depth.values)
        if (value > 0)
            found.push_back(value);
    if (found.empty())
        return 1;
    const auto place = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 50);
    std::ranges::nth_element(found, place);
    return static_cast<double>(*place);
}

template <class ColorOf>
Raster8 painted(int width, int height, const ColorOf& color_of)
{
    Raster8 result(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const Rgb8 color = color_of(x, y);
            std::ranges::copy(color, &result.at(x, y));
        }
    return result;
}

std::vector<Raster8> tiles_of(const Panel& panel)
{
    std::vector<Raster8> tiles;
    const auto add = [&](const auto& size, const auto& color_of) { tiles.push_back(painted(size.width, size.height, color_of)); };
    const Raster8& picture = panel.picture;
    if (!picture.empty())
        add(picture,
            [&](int x, int y)
            {
                if (panel.outlined.at(x, y) != 0)
                    return panel.suggested ? as_suggested : as_recorded;
                return Rgb8{picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2)};
            });
    if (panel.measured.empty())
        return tiles;
    const double nearest = nearest_of(panel.measured);
    const auto measured = [&](int x, int y) { return static_cast<double>(panel.measured.at(x, y)); };
    const auto mesh = [&](int x, int y) { return static_cast<double>(panel.mesh.at(x, y)); };
    add(panel.measured, [&](int x, int y) { return depth_color(measured(x, y), nearest); });
    add(panel.measured, [&](int x, int y) { return depth_color(mesh(x, y), nearest); });
    add(panel.measured, [&](int x, int y) { return difference_color(mesh(x, y), measured(x, y)); });
    return tiles;
}

}  // namespace

Raster8 draw(const std::vector<Panel>& panels)
{
    std::vector<std::vector<Raster8>> rows;
    int width = 1;
    int height = gap;
    for (const Panel& panel : panels)
    {
        rows.push_back(tiles_of(panel));
        int row_width = gap;
        for (const Raster8& tile : rows.back())
            row_width += tile.width + gap;
        width = std::max(width, row_width);
        height += gap + (rows.back().empty() ? 0 : panel_height_px);
    }
    Raster8 sheet = painted(width, height, [](int, int) { return background; });
    int top = gap;
    for (const auto& row : rows)
    {
        int left = gap;
        for (const Raster8& tile : row)
        {
            for (int y = 0; y < tile.height; ++y)
                std::copy_n(&tile.at(0, y), 3 * tile.width, &sheet.at(left, top + y));
            left += tile.width + gap;
        }
        top += gap + (row.empty() ? 0 : panel_height_px);
    }
    return sheet;
}

}  // namespace fresco::inspect

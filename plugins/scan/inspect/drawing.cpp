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

void put(Raster8& to, int x, int y, Rgb8 color)
{
    for (int c = 0; c < 3; ++c)
        to.at(x, y, c) = color[static_cast<std::size_t>(c)];
}

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

Raster8 outlined_picture(const Panel& panel)
{
    Raster8 result = panel.picture;
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
            if (panel.outlined.at(x, y) != 0)
                put(result, x, y, panel.suggested ? as_suggested : as_recorded);
    return result;
}

template <class ColorOf>
Raster8 painted(const RasterF& size, const ColorOf& color_of)
{
    Raster8 result(size.width, size.height, 3);
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x)
            put(result, x, y, color_of(x, y));
    return result;
}

std::vector<Raster8> tiles_of(const Panel& panel)
{
    std::vector<Raster8> tiles;
    if (!panel.picture.empty())
        tiles.push_back(outlined_picture(panel));
    if (panel.measured.empty())
        return tiles;
    const auto at = [](const RasterF& raster, int x, int y) { return static_cast<double>(raster.at(x, y)); };
    const double nearest = nearest_of(panel.measured);
    tiles.push_back(painted(panel.measured, [&](int x, int y) { return depth_color(at(panel.measured, x, y), nearest); }));
    tiles.push_back(painted(panel.measured, [&](int x, int y) { return depth_color(at(panel.mesh, x, y), nearest); }));
    tiles.push_back(
        painted(panel.measured, [&](int x, int y) { return difference_color(at(panel.mesh, x, y), at(panel.measured, x, y)); }));
    return tiles;
}

}  // namespace

Raster8 draw(const std::vector<Panel>& panels)
{
    std::vector<std::vector<Raster8>> rows;
    int width = 0;
    int height = gap;
    for (const Panel& panel : panels)
    {
        rows.push_back(tiles_of(panel));
        int row_width = gap;
        int row_height = 0;
        for (const Raster8& tile : rows.back())
        {
            row_width += tile.width + gap;
            row_height = std::max(row_height, tile.height);
        }
        width = std::max(width, row_width);
        height += row_height + gap;
    }
    Raster8 sheet(std::max(width, 1), height, 3);
    for (int y = 0; y < sheet.height; ++y)
        for (int x = 0; x < sheet.width; ++x)
            put(sheet, x, y, background);
    int top = gap;
    for (const auto& row : rows)
    {
        int left = gap;
        int row_height = 0;
        for (const Raster8& tile : row)
        {
            for (int y = 0; y < tile.height; ++y)
                std::copy_n(tile.values.begin() + static_cast<std::ptrdiff_t>(tile.index(0, y)), 3 * tile.width,
                            sheet.values.begin() + static_cast<std::ptrdiff_t>(sheet.index(left, top + y)));
            left += tile.width + gap;
            row_height = std::max(row_height, tile.height);
        }
        top += row_height + gap;
    }
    return sheet;
}

}  // namespace fresco::inspect

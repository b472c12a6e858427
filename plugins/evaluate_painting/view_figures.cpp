#include "view_figures.h"

#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/images/lab.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <string>

using namespace fresco;

namespace
{
constexpr int style_side_px = 256;
constexpr int longest_style = 16;  // Times the shorter side.
constexpr int margin_px = 8;
constexpr int erosion_px = 6;
constexpr int dark_sum = 5;

double relative(double value, double reference)
{
    return reference > 0 ? value / reference : std::numeric_limits<double>::quiet_NaN();
}

double ratio(double value, double reference)
{
    return value == 0 ? 0 : value / reference;
}

RasterF style_lab(const Raster8& picture)
{
    const int shorter = std::min(picture.width, picture.height);
    const int longer = std::max(picture.width, picture.height);
    const Raster8 rgb = on_white(picture);
    if (longer > longest_style * shorter)
        throw Error(fmt::format(
            "the picture on port 'style' is {} x {}; its longer side may be at most {} times the shorter one; crop it",
            picture.width, picture.height, longest_style));
    const auto side = [&](int px) { return static_cast<int>(std::lround(static_cast<double>(px) * style_side_px / shorter)); };
    return lab_picture(resized(rgb, side(picture.width), side(picture.height)));
}

void clear_margin(Raster8& mask)
{
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
            if (std::min({x, y, mask.width - 1 - x, mask.height - 1 - y}) < margin_px)
                mask.at(x, y) = 0;
}

Raster8 inner_pixels(const RasterF& lab)
{
    Raster8 mask(lab.width, lab.height, 1, 1);
    clear_margin(mask);
    return mask;
}

double coherence(const RasterF& blurred_l, const Raster8& mask)
{
    const Gradient g = sobel(blurred_l);
    RasterF products(blurred_l.width, blurred_l.height, 3);
    for (std::size_t i = 0; i < g.x.values.size(); ++i)
    {
        const float x = g.x.values[i];
        const float y = g.y.values[i];
        products.values[3 * i] = x * x;
        products.values[3 * i + 1] = y * y;
        products.values[3 * i + 2] = x * y;
    }
    const RasterF tensor = blurred(products, 3);
    double directed = 0;
    double all = 0;
    for (std::size_t i = 0; i < mask.values.size(); ++i)
    {
        if (mask.values[i] == 0)
            continue;
        const float xx = tensor.values[3 * i];
        const float yy = tensor.values[3 * i + 1];
        const float xy = tensor.values[3 * i + 2];
        directed += double{std::sqrt((xx - yy) * (xx - yy) + 4 * xy * xy)};
        all += double{xx + yy};
    }
    return ratio(directed, all);
}
}  // namespace

Raster8 on_white(const Raster8& picture)
{
    if (picture.empty() || (picture.channels != 1 && picture.channels != 3 && picture.channels != 4))
        throw Error(fmt::format("the picture on port 'style' is {} x {} with {} channels; expected 1 (gray), 3 (RGB) or 4 (RGBA)",
                                picture.width, picture.height, picture.channels));
    Raster8 rgb(picture.width, picture.height, 3);
    for (std::size_t i = 0; i * 3 < rgb.values.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
        {
            const auto channels = static_cast<std::size_t>(picture.channels);
            const int value = picture.values[i * channels + (channels == 1 ? 0 : c)];
            const int alpha = channels == 4 ? picture.values[i * channels + 3] : 255;
            rgb.values[i * 3 + c] = static_cast<std::uint8_t>((value * alpha + 255 * (255 - alpha) + 127) / 255);
        }
    return rgb;
}

Raster8 covered_pixels(const Raster8& picture)
{
    Raster8 covered(picture.width, picture.height);
    const auto channels = static_cast<std::size_t>(picture.channels);
    for (std::size_t i = 0; i < covered.values.size(); ++i)
    {
        const std::uint8_t* const pixel = &picture.values[i * channels];
        covered.values[i] = (channels == 4 ? pixel[3] > 0 : pixel[0] + pixel[1] + pixel[2] > dark_sum) ? 1 : 0;
    }
    return covered;
}

JudgedPixels judged_pixels(const Raster8& covered)
{
    JudgedPixels result{eroded(covered, erosion_px), 0};
    clear_margin(result.mask);
    result.count = static_cast<std::size_t>(std::ranges::count(result.mask.values, 1));
    return result;
}

Appearance appearance(const RasterF& lab, const Raster8& mask)
{
    const RasterF fine = blurred(lab, 1);
    const RasterF blurred_l = channel(fine, 0);
    const RasterF coarse_l = blurred(channel(lab, 0), 4);
    double luma = 0;
    double chroma = 0;
    double band = 0;
    double count = 0;
    for (std::size_t i = 0; i < mask.values.size(); ++i)
    {
        if (mask.values[i] == 0)
            continue;
        const auto squared = [](float v) { return double{v} * double{v}; };
        const auto detail = [&](std::size_t c) { return squared(lab.values[3 * i + c] - fine.values[3 * i + c]); };
        luma += detail(0);
        chroma += detail(1) + detail(2);
        band += squared(blurred_l.values[i] - coarse_l.values[i]);
        ++count;
    }
    return {coherence(blurred_l, mask), std::sqrt(ratio(chroma, luma)), std::sqrt(ratio(band, count))};
}

StylePicture::StylePicture(const Raster8& picture) : StylePicture(style_lab(picture)) {}

StylePicture::StylePicture(const RasterF& lab) : palette(lab), look(appearance(lab, inner_pixels(lab)))
{
    if (look.strokes < 1e-3)
        throw Error("the picture on port 'style' has a single color, so it has no strokes to compare with; use a picture with "
                    "brush strokes");
}

ViewFigures view_figures(const Raster8& view, const JudgedPixels& pixels, const StylePicture& style)
{
    Raster8 rgb(view.width, view.height, 3);
    const auto channels = static_cast<std::size_t>(view.channels);
    for (std::size_t i = 0; i * 3 < rgb.values.size(); ++i)
        std::copy_n(&view.values[i * channels], 3, &rgb.values[i * 3]);
    const RasterF lab = lab_picture(rgb);
    std::size_t off = 0;
    for (std::size_t i = 0; i < pixels.mask.values.size(); ++i)
        if (pixels.mask.values[i] != 0 &&
            !style.palette.is_near({lab.values[3 * i], lab.values[3 * i + 1], lab.values[3 * i + 2]}))
            ++off;
    const Appearance look = appearance(lab, pixels.mask);
    return {static_cast<double>(off) / static_cast<double>(pixels.count), relative(look.coherence, style.look.coherence),
            relative(look.chroma_noise, style.has_chroma() ? style.look.chroma_noise : 0),
            relative(look.strokes, style.look.strokes)};
}

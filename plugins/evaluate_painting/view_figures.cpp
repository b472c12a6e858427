#include "view_figures.h"

#include <fresco/error.h>
#include <fresco/evaluation/statistics.h>
#include <fresco/images/filters.h>
#include <fresco/images/lab.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

using namespace fresco;

namespace
{

constexpr float cell_side = 2;
constexpr float reach = 10;
constexpr int reach_cells = 6;  // For colors that are half a cell off.
// Cells of L* in 0..100, a* and b* of any displayed color, and a rim that is_near may look into.
constexpr int least_l = -reach_cells;
constexpr int count_l = 51 + 2 * reach_cells;
constexpr int least_ab = -64 - reach_cells;
constexpr int count_ab = 129 + 2 * reach_cells;

struct LabCell
{
    int l, a, b;
};

LabCell cell_of(Vec3f lab)
{
    // Halves go to the even cell, as NumPy rounds them.
    const auto rounded = [](float v, int least, int most)
    { return std::clamp(static_cast<int>(std::nearbyint(v / cell_side)), least, most); };
    return {rounded(lab.x, 0, 50), rounded(lab.y, -64, 64), rounded(lab.z, -64, 64)};
}

std::size_t index_of(LabCell c)
{
    return (static_cast<std::size_t>(c.l - least_l) * count_ab + static_cast<std::size_t>(c.a - least_ab)) * count_ab +
           static_cast<std::size_t>(c.b - least_ab);
}

/// Steps between cells that may be within reach, the shortest first.
const std::vector<LabCell>& steps()
{
    static const std::vector<LabCell> result = []
    {
        std::vector<LabCell> all;
        for (int l = -reach_cells; l <= reach_cells; ++l)
            for (int a = -reach_cells; a <= reach_cells; ++a)
                for (int b = -reach_cells; b <= reach_cells; ++b)
                    // A color may be half a cell off along each axis.
                    if (std::sqrt(static_cast<float>(l * l + a * a + b * b)) * cell_side <= reach + 1.7321F * cell_side / 2)
                        all.push_back({l, a, b});
        std::ranges::stable_sort(all, {}, [](const LabCell& c) { return c.l * c.l + c.a * c.a + c.b * c.b; });
        return all;
    }();
    return result;
}

}  // namespace

Palette::Palette(const RasterF& lab) : cells_(std::size_t{count_l} * count_ab * count_ab)
{
    for (std::size_t i = 0; i + 2 < lab.values.size(); i += 3)
        cells_[index_of(cell_of({lab.values[i], lab.values[i + 1], lab.values[i + 2]}))] = 1;
}

bool Palette::is_near(Vec3f color) const
{
    const LabCell own = cell_of(color);
    for (const LabCell& step : steps())
    {
        const LabCell c{own.l + step.l, own.a + step.a, own.b + step.b};
        if (cells_[index_of(c)] == 0)
            continue;
        const Vec3f away = color - Vec3f{static_cast<float>(c.l), static_cast<float>(c.a), static_cast<float>(c.b)} * cell_side;
        if (dot(away, away) <= reach * reach)
            return true;
    }
    return false;
}

namespace
{

constexpr int height_px = 256;
constexpr double sigma_px = 3;
constexpr int cell_px = 4;
constexpr double around_cells = 3;
constexpr std::size_t classes = 8;
constexpr std::size_t least_cells = 500;
constexpr int edge_erosion_px = 7;
constexpr std::size_t least_pixels = 1000;

/// L* and how much of each pixel is covered, 0..1.
struct Lightness
{
    RasterF value;
    RasterF weight;
};

/// A picture at another size: RGB is averaged over covered pixels only.
Lightness lightness(const Raster8& picture, const Raster8& covered, int width, int height)
{
    RasterF weighted(picture.width, picture.height, 4);
    const auto channels = static_cast<std::size_t>(picture.channels);
    for (std::size_t i = 0; i < covered.values.size(); ++i)
        if (covered.values[i] != 0)
        {
            for (std::size_t c = 0; c < 3; ++c)
                weighted.values[4 * i + c] = static_cast<float>(picture.values[i * channels + c]) / 255;
            weighted.values[4 * i + 3] = 1;
        }
    weighted = resized(weighted, width, height);
    Lightness result{RasterF(width, height), channel(weighted, 3)};
    for (std::size_t i = 0; i < result.value.values.size(); ++i)
        if (const float weight = result.weight.values[i]; weight > 0)
            result.value.values[i] =
                lab_from_rgb(Vec3f{weighted.values[4 * i], weighted.values[4 * i + 1], weighted.values[4 * i + 2]} * (1 / weight))
                    .x;
    return result;
}

/// A blur in which pixels count by `weight`. `blurred_weight`: blurred by the same sigma.
RasterF blurred(RasterF value, const RasterF& weight, const RasterF& blurred_weight, double sigma)
{
    for (std::size_t i = 0; i < value.values.size(); ++i)
        value.values[i] *= weight.values[i];
    value = fresco::blurred(value, sigma);
    for (std::size_t i = 0; i < value.values.size(); ++i)
        value.values[i] = blurred_weight.values[i] > 0 ? value.values[i] / blurred_weight.values[i] : 0;
    return value;
}

int width_at(int height, const Raster8& view)
{
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(view.width) * height / view.height)));
}

/// Which of the classes each value is in: equal values are in one.
std::vector<std::size_t> classes_of(const std::vector<float>& values)
{
    std::vector<float> sorted = values;
    std::ranges::sort(sorted);
    std::vector<std::size_t> result(values.size());
    std::ranges::transform(values, result.begin(),
                           [&](float v)
                           {
                               const auto below = static_cast<std::size_t>(std::ranges::lower_bound(sorted, v) - sorted.begin());
                               return below * classes / sorted.size();
                           });
    return result;
}

}  // namespace

double edge_correlation(const Raster8& view, const Raster8& covered, const Raster8& camera)
{
    const int width = width_at(height_px, view);
    const Lightness seen = lightness(view, covered, width, height_px);
    const Lightness recorded = lightness(camera, Raster8(camera.width, camera.height, 1, 1), width, height_px);
    const RasterF blurred_weight = blurred(seen.weight, sigma_px);
    const Gradient a = sobel(blurred(seen.value, seen.weight, blurred_weight, sigma_px));
    const Gradient b = sobel(blurred(recorded.value, seen.weight, blurred_weight, sigma_px));

    Raster8 mask(width, height_px);
    std::ranges::transform(seen.weight.values, mask.values.begin(),
                           [](float weight) { return weight > 0.5F ? std::uint8_t{1} : std::uint8_t{0}; });
    mask = eroded(mask, edge_erosion_px);
    std::vector<double> of_view;
    std::vector<double> of_camera;
    for (std::size_t i = 0; i < mask.values.size(); ++i)
        if (mask.values[i] != 0)
        {
            of_view.insert(of_view.end(), {double{a.x.values[i]}, double{a.y.values[i]}});
            of_camera.insert(of_camera.end(), {double{b.x.values[i]}, double{b.y.values[i]}});
        }
    return of_view.size() < 2 * least_pixels ? std::numeric_limits<double>::quiet_NaN() : evaluation::pearson(of_view, of_camera);
}

double legibility(const Raster8& view, const Raster8& covered, const Raster8& camera)
{
    constexpr int height = height_px / cell_px;
    const int width = width_at(height, view);
    const Lightness seen = lightness(view, covered, width, height);
    const Lightness recorded = lightness(camera, Raster8(camera.width, camera.height, 1, 1), width, height);
    const RasterF blurred_weight = blurred(seen.weight, around_cells);
    const RasterF around_seen = blurred(seen.value, seen.weight, blurred_weight, around_cells);
    const RasterF around_recorded = blurred(recorded.value, seen.weight, blurred_weight, around_cells);
    std::vector<float> of_view;
    std::vector<float> of_camera;
    for (std::size_t i = 0; i < seen.value.values.size(); ++i)
        if (seen.weight.values[i] > 0.99F)
        {
            of_view.push_back(seen.value.values[i] - around_seen.values[i]);
            of_camera.push_back(recorded.value.values[i] - around_recorded.values[i]);
        }
    if (of_view.size() < least_cells)
        return std::numeric_limits<double>::quiet_NaN();
    const std::vector<std::size_t> a = classes_of(of_view);
    const std::vector<std::size_t> b = classes_of(of_camera);
    std::array<std::array<double, classes>, classes> both{};
    std::array<double, classes> first{};
    std::array<double, classes> second{};
    const double share = 1 / static_cast<double>(a.size());
    for (std::size_t i = 0; i < a.size(); ++i)
    {
        both[a[i]][b[i]] += share;
        first[a[i]] += share;
        second[b[i]] += share;
    }
    double information = -0.5 * share * (classes - 1) * (classes - 1);
    for (std::size_t i = 0; i < classes; ++i)
        for (std::size_t j = 0; j < classes; ++j)
            if (both[i][j] > 0)
                information += both[i][j] * std::log(both[i][j] / (first[i] * second[j]));
    return information / std::log(double{classes});
}

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
    Raster8& mask = result.mask;
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
            if (std::min({x, y, mask.width - 1 - x, mask.height - 1 - y}) < margin_px)
                mask.at(x, y) = 0;
    result.count = static_cast<std::size_t>(std::ranges::count(result.mask.values, 1));
    return result;
}

namespace
{

/// `lab`: H x W x 3, `mask`: H x W. All are 0 without variation; chroma_noise is infinite if only a* and b* vary.
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

}  // namespace

StylePicture::StylePicture(const Raster8& picture) : StylePicture(style_lab(picture)) {}

StylePicture::StylePicture(const RasterF& lab)
    : palette(lab), look(appearance(lab, judged_pixels(Raster8(lab.width, lab.height, 1, 1)).mask))
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

namespace
{

struct ViewFigure
{
    const char* name;
    double (*of)(const JudgedView&);
    Wanted wanted;
};
constexpr std::array view_figures_wanted{
    ViewFigure{"off_palette", [](const JudgedView& view) { return view.figures.off_palette; }, {.high = 0.005}},
    ViewFigure{"coherence", [](const JudgedView& view) { return view.figures.coherence; }, {0.8, 1.2}},
    ViewFigure{"chroma_noise", [](const JudgedView& view) { return view.figures.chroma_noise; }, {0.6, 1.6}},
    ViewFigure{"strokes", [](const JudgedView& view) { return view.figures.strokes; }, {0.65}},
    ViewFigure{"edges", [](const JudgedView& view) { return view.edges; }, {0.5}},
    ViewFigure{"legible", [](const JudgedView& view) { return view.legible; }, {0.1}}};

}  // namespace

JudgedView judged_view(const std::string& name, const Raster8& view, const StylePicture* style,
                       const std::function<Raster8()>& camera)
{
    const Raster8 covered = covered_pixels(view);
    const JudgedPixels pixels = judged_pixels(covered);
    JudgedView judged;
    judged.name = name;
    judged.skipped = pixels.count < JudgedView::least_pixels;
    if (!judged.skipped && style != nullptr)
        judged.figures = view_figures(view, pixels, *style);
    if (!judged.skipped && camera)
    {
        const Raster8 recorded = camera();
        judged.edges = edge_correlation(view, covered, recorded);
        judged.legible = legibility(view, covered, recorded);
    }
    return judged;
}

std::vector<Figure> figures_over(const std::vector<JudgedView>& views)
{
    std::vector<std::string> names(views.size());
    std::ranges::transform(views, names.begin(), &JudgedView::name);
    std::vector<Figure> found;
    for (const ViewFigure& figure : view_figures_wanted)
    {
        std::vector<double> values(views.size());
        std::ranges::transform(views, values.begin(), figure.of);
        if (auto over = over_views(figure.name, figure.wanted, values, names))
            found.push_back(std::move(*over));
    }
    return found;
}

Value views_value(const std::vector<JudgedView>& views)
{
    Value::List list;
    for (const JudgedView& view : views)
    {
        Value::Map entry{{"view", view.name}};
        if (view.skipped)
            entry.emplace_back("skipped", true);
        for (const ViewFigure& figure : view_figures_wanted)
            if (const double value = figure.of(view); std::isfinite(value))
                entry.emplace_back(figure.name, value);
        list.push_back(std::move(entry));
    }
    return list;
}

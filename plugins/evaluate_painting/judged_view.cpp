#include "judged_view.h"
#include "edges.h"

#include <algorithm>
#include <array>
#include <cmath>

using fresco::Raster8;
using fresco::Value;

namespace
{
struct ViewFigure
{
    const char* name;
    double (*of)(const JudgedView&);
    Wanted wanted;
};
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::array view_figures_wanted{
    ViewFigure{"off_palette", [](const JudgedView& view) { return view.figures.off_palette; }, {-infinity, 0.005}},
    ViewFigure{"coherence", [](const JudgedView& view) { return view.figures.coherence; }, {0.8, 1.2}},
    ViewFigure{"chroma_noise", [](const JudgedView& view) { return view.figures.chroma_noise; }, {0.6, 1.6}},
    ViewFigure{"strokes", [](const JudgedView& view) { return view.figures.strokes; }, {0.65, infinity}},
    ViewFigure{"edges", [](const JudgedView& view) { return view.edges; }, {0.5, infinity}}};
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
        judged.edges = edge_correlation(view, covered, camera());
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

#include "report/report_charts.h"

#include "report/report_figures.h"

#include <fresco/error.h>
#include <fresco/html.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace fresco::host
{
namespace
{

struct Series
{
    std::vector<std::pair<double, double>> points;
    double low = 0;
    double high = 0;
};

Series series_of(const Value::List& done, const Value::List& values)
{
    Series series;
    for (std::size_t i = 0; i < done.size() && i < values.size(); ++i)
        if (values[i].is_number())
        {
            const double y = values[i].as_double();
            series.low = series.points.empty() ? y : std::min(series.low, y);
            series.high = series.points.empty() ? y : std::max(series.high, y);
            series.points.emplace_back(done[i].as_double(), y);
        }
    return series;
}

/// The mean over a window around each point that grows with the number of points.
std::vector<double> smoothed(const Series& series)
{
    const std::size_t half = series.points.size() / 40;
    std::vector<double> result;
    for (std::size_t i = 0; i < series.points.size(); ++i)
    {
        const std::size_t reach = std::min({half, i, series.points.size() - 1 - i});
        double sum = 0;
        for (std::size_t k = i - reach; k <= i + reach; ++k)
            sum += series.points[k].second;
        result.push_back(sum / static_cast<double>(2 * reach + 1));
    }
    return result;
}

/// From values to places within a chart.
class Axes
{
  public:
    static constexpr double width = 560;
    static constexpr double height = 190;
    static constexpr double left = 64;
    static constexpr double right = 8;
    static constexpr double top = 10;
    static constexpr double bottom = 24;

    Axes(double x_low, double x_high, double y_low, double y_high, bool logarithmic)
        : x_low_(x_low), x_high_(x_high > x_low ? x_high : x_low + 1), logarithmic_(logarithmic), y_low_(scaled(y_low)),
          y_high_(scaled(y_high) > scaled(y_low) ? scaled(y_high) : scaled(y_low) + 1)
    {
    }
    double x(double value) const { return left + (value - x_low_) / (x_high_ - x_low_) * (width - left - right); }
    double y(double value) const
    {
        return height - bottom - (scaled(value) - y_low_) / (y_high_ - y_low_) * (height - top - bottom);
    }

  private:
    double scaled(double value) const { return logarithmic_ ? std::log10(value) : value; }

    double x_low_;
    double x_high_;
    bool logarithmic_;
    double y_low_;
    double y_high_;
};

std::vector<double> value_ticks(double low, double high, bool logarithmic)
{
    if (!logarithmic)
        return round_ticks(low, high, 4);
    std::vector<double> ticks;
    for (int power = static_cast<int>(std::ceil(std::log10(low))); std::pow(10.0, power) <= high; ++power)
        ticks.push_back(std::pow(10.0, power));
    return ticks;
}

std::string curve_chart(const std::string& name, const std::string& unit, const Series& series)
{
    constexpr double wide_range = 30;
    const bool logarithmic = series.low > 0 && series.high > wide_range * series.low;
    const double x_low = series.points.front().first;
    const double x_high = series.points.back().first;
    const double y_low =
        logarithmic || series.low < 0 ? series.low : std::min(series.low, series.high / 2 < series.low ? series.low : 0.0);
    const Axes axes(x_low, x_high, y_low, series.high, logarithmic);
    std::string label = name;
    std::ranges::replace(label, '_', ' ');
    std::string svg = fmt::format("<figure><svg class=\"chart\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">",
                                  Axes::width, Axes::height, html_escaped(label));
    for (const double tick : value_ticks(y_low, series.high, logarithmic))
        svg += fmt::format(
            "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text x=\"{3:.1f}\" y=\"{4:.1f}\" class=\"end\">{5}</text>",
            Axes::left, axes.y(tick), Axes::width - Axes::right, Axes::left - 6, axes.y(tick) + 4, figure_text(tick));
    for (const double tick : round_ticks(x_low, x_high, 6))
        svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"middle\">{}</text>", axes.x(tick), Axes::height - 7,
                           figure_text(tick));
    const std::vector<double> means = smoothed(series);
    std::string raw;
    std::string smooth;
    for (std::size_t i = 0; i < series.points.size(); ++i)
    {
        const auto& [x, y] = series.points[i];
        const char* command = i == 0 ? "M" : "L";
        raw += fmt::format("{}{:.1f} {:.1f}", command, axes.x(x), axes.y(y));
        smooth += fmt::format("{}{:.1f} {:.1f}", command, axes.x(x), axes.y(means[i]));
    }
    svg += "<path class=\"raw\" d=\"" + raw + "\"/><path class=\"smooth\" d=\"" + smooth + "\"/></svg>";
    return svg + fmt::format("<figcaption>{} over {}: first {}, last {}, least {}</figcaption></figure>\n", html_escaped(label),
                             html_escaped(unit.empty() ? "time" : unit), figure_text(series.points.front().second),
                             figure_text(series.points.back().second), figure_text(series.low));
}

struct JudgedFrame
{
    std::string name;
    double value = 0;
    bool kept = false;
};

std::vector<JudgedFrame> judged_frames(const Value& judged)
{
    std::vector<JudgedFrame> frames;
    const auto& names = judged.at("names").as_list();
    const auto& values = judged.at("values").as_list();
    const auto& kept = judged.at("kept").as_list();
    if (values.size() != names.size() || kept.size() != names.size())
        return frames;
    for (std::size_t i = 0; i < names.size(); ++i)
        frames.push_back({names[i].as_string(), values[i].is_number() ? values[i].as_double() : 0.0, kept[i].as_bool()});
    return frames;
}

std::string frame_bars(const std::vector<JudgedFrame>& frames, double least, const std::string& measure)
{
    constexpr double width = 1000;
    constexpr double height = 150;
    constexpr double top = 6;
    constexpr std::size_t most_bars = 1000;
    const std::size_t per_bar = (frames.size() + most_bars - 1) / most_bars;
    const std::size_t bars = (frames.size() + per_bar - 1) / per_bar;
    double highest = least;
    for (const JudgedFrame& frame : frames)
        highest = std::max(highest, frame.value);
    const double scale = highest > 0 ? (height - top) / highest : 0;
    const double step = width / static_cast<double>(bars);
    std::string svg = fmt::format("<svg class=\"frames\" viewBox=\"0 0 {:.0f} {:.0f}\" preserveAspectRatio=\"none\" role=\"img\" "
                                  "aria-label=\"{} of every frame\">",
                                  width, height, html_escaped(measure));
    for (std::size_t bar = 0; bar < bars; ++bar)
    {
        const auto begin = frames.begin() + static_cast<std::ptrdiff_t>(bar * per_bar);
        const auto end = frames.begin() + static_cast<std::ptrdiff_t>(std::min(frames.size(), (bar + 1) * per_bar));
        const JudgedFrame& frame = *std::max_element(begin, end, [](const auto& a, const auto& b) { return a.value < b.value; });
        const double size = std::max(1.0, frame.value * scale);
        const char* verdict = frame.kept ? "kept" : frame.value < least ? "below" : "dropped";
        svg += fmt::format(
            "<rect class=\"{}\" x=\"{:.2f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"{:.1f}\"><title>{}: {} {}{}</title></rect>",
            verdict, static_cast<double>(bar) * step, height - size, std::max(0.5, step * 0.85), size, html_escaped(frame.name),
            html_escaped(measure), figure_text(frame.value), frame.kept ? "" : ", dropped");
    }
    if (least > 0)
        svg += fmt::format("<path class=\"least\" d=\"M0 {0:.1f}H{1:.0f}\"/>", height - least * scale, width);
    return svg + "</svg>";
}

}  // namespace

std::vector<double> round_ticks(double low, double high, int count)
{
    if (!(high > low) || count < 1)
        return {low};
    const double rough = (high - low) / count;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    const double step = power * (rough / power > 7 ? 10 : rough / power > 3 ? 5 : rough / power > 1.5 ? 2 : 1);
    std::vector<double> ticks;
    for (double index = std::ceil(low / step - 1e-9); index * step <= high + 1e-9 * step; ++index)
    {
        const double tick = index == 0 ? 0.0 : index * step;
        if (!ticks.empty() && tick <= ticks.back())
            break;  // So far from 0 that the next whole number is the same.
        ticks.push_back(tick);
    }
    return ticks;
}

std::string curve_charts(const Value& curves)
{
    std::string charts;
    try
    {
        if (!curves.is_map())
            return charts;
        for (const auto& [name, values] : curves.at("metrics").as_map())
            if (const Series series = series_of(curves.at("done").as_list(), values.as_list()); series.points.size() > 1)
                charts += curve_chart(name, curves.at("unit").as_string(), series);
    }
    catch (const Error&)
    {
        charts.clear();
    }
    return charts;
}

std::string frames_chart(const Value& judged)
{
    try
    {
        const std::vector<JudgedFrame> frames = judged_frames(judged);
        if (frames.empty())
            return "";
        const double least =
            judged.find("least") != nullptr && judged.at("least").is_number() ? judged.at("least").as_double() : 0;
        const std::string& measure = judged.at("measure").as_string();
        const auto kept = std::ranges::count_if(frames, &JudgedFrame::kept);
        const auto below =
            std::ranges::count_if(frames, [&](const JudgedFrame& frame) { return !frame.kept && frame.value < least; });
        const auto other = static_cast<std::ptrdiff_t>(frames.size()) - kept - below;
        std::string caption = fmt::format("<span class=\"key kept\"></span>{} kept", kept);
        if (below > 0)
            caption +=
                fmt::format(" <span class=\"key below\"></span>{} below {} {}", below, html_escaped(measure), figure_text(least));
        if (other > 0)
            caption += fmt::format(" <span class=\"key dropped\"></span>{} dropped beside others", other);
        return "<figure>" + frame_bars(frames, least, measure) + "<figcaption>" + html_escaped(measure) + " of " +
               std::to_string(frames.size()) + " frames in recorded order: " + caption + "</figcaption></figure>\n";
    }
    catch (const Error&)
    {
        return "";
    }
}

}  // namespace fresco::host

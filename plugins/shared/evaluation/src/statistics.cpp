#include <fresco/evaluation/statistics.h>
#include <fresco/files_io.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <utility>
#include <vector>

namespace fresco::evaluation
{

namespace
{

constexpr double confidence = 0.95;
constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

/// Linear between the order statistics; `sorted` is not empty.
double quantile(const std::vector<double>& sorted, double share)
{
    const double at = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(at);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return sorted[below] + (sorted[above] - sorted[below]) * (at - static_cast<double>(below));
}

std::string digits(double value)
{
    return std::isfinite(value) ? fmt::format("{:.4g}", value) : "undefined";
}

}  // namespace

double mean(std::span<const double> values)
{
    double sum = 0;
    for (const double value : values)
        sum += value;
    return values.empty() ? undefined : sum / static_cast<double>(values.size());
}

double pearson(std::span<const double> x, std::span<const double> y)
{
    const double mean_x = mean(x);
    const double mean_y = mean(y);
    double xx = 0;
    double yy = 0;
    double xy = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
    {
        const double dx = x[i] - mean_x;
        const double dy = y[i] - mean_y;
        xx += dx * dx;
        yy += dy * dy;
        xy += dx * dy;
    }
    return x.size() >= 2 && xx > 0 && yy > 0 ? std::clamp(xy / std::sqrt(xx * yy), -1.0, 1.0) : undefined;
}

Interval bootstrap_interval(std::size_t groups, const GroupStatistic& statistic, const Bootstrap& bootstrap)
{
    const auto draws = static_cast<std::size_t>(bootstrap.resamples);
    if (groups < 2 || draws == 0)
        return {undefined, undefined};
    Random random(bootstrap.seed);
    std::vector<std::size_t> drawn(groups);
    std::vector<double> found;
    for (std::size_t draw = 0; draw < draws; ++draw)
    {
        std::ranges::generate(drawn, [&] { return static_cast<std::size_t>(random.below(static_cast<std::int64_t>(groups))); });
        if (const double value = statistic(drawn); std::isfinite(value))
            found.push_back(value);
    }
    if (found.size() * 2 < draws)
        return {undefined, undefined};
    std::ranges::sort(found);
    const double tail = (1 - confidence) / 2;
    return {quantile(found, tail), quantile(found, 1 - tail)};
}

Interval bootstrap_mean(std::span<const double> values, const Bootstrap& bootstrap)
{
    const auto mean_of = [&](std::span<const std::size_t> drawn)
    {
        double sum = 0;
        for (const std::size_t i : drawn)
            sum += values[i];
        return sum / static_cast<double>(drawn.size());
    };
    return bootstrap_interval(values.size(), mean_of, bootstrap);
}

std::string figure_text(double value, Interval interval)
{
    return digits(value) + " [" + digits(interval.low) + ", " + digits(interval.high) + "]";
}

Value number_or_null(double value)
{
    return std::isfinite(value) ? Value(value) : Value();
}

Value figure(double value, Interval interval)
{
    return Value::Map{
        {"value", number_or_null(value)}, {"low", number_or_null(interval.low)}, {"high", number_or_null(interval.high)}};
}

Files write_figures(const ArtifactFolder& folder, const std::string& path, const Value& figures)
{
    const auto file = folder.path / path;
    std::filesystem::create_directories(file.parent_path());
    write_file(file, to_json(figures, 1) + "\n");
    Files made;
    made.names = {path};
    return made;
}

}  // namespace fresco::evaluation

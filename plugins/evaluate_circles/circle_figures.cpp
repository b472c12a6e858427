#include "circle_figures.h"

#include <cmath>
#include <limits>
#include <numeric>

using namespace fresco;

namespace
{
/// The columns that the statistics are taken of.
struct Columns
{
    std::vector<double> depth_2d;
    std::vector<double> radius_px;
    std::vector<double> depth_3d;
    std::vector<double> radius_m;
    std::vector<double> stretch;

    void add(const std::vector<Circle>& circles)
    {
        for (const Circle& circle : circles)
        {
            depth_2d.push_back(circle.depth);
            radius_px.push_back(circle.ellipse.radius_px());
            if (!circle.world)
                continue;
            depth_3d.push_back(circle.depth);
            radius_m.push_back(circle.world->radius_m);
            stretch.push_back(circle.world->stretch);
        }
    }

    CircleStatistics statistics() const
    {
        return {evaluation::pearson(depth_2d, radius_px), evaluation::pearson(depth_3d, radius_m), evaluation::mean(stretch)};
    }
};

/// A mean of those values that are defined.
class WeightedMean
{
  public:
    void add(double value, double weight)
    {
        if (!std::isfinite(value))
            return;
        sum_ += value * weight;
        weights_ += weight;
    }
    double value() const { return weights_ > 0 ? sum_ / weights_ : std::numeric_limits<double>::quiet_NaN(); }

  private:
    double sum_ = 0;
    double weights_ = 0;
};
}  // namespace

CircleStatistics circle_statistics(const std::vector<std::vector<Circle>>& pictures, std::span<const std::size_t> drawn,
                                   Protocol protocol)
{
    if (protocol == Protocol::paper)
    {
        Columns all;
        for (const std::size_t i : drawn)
            all.add(pictures[i]);
        return all.statistics();
    }
    WeightedMean corr_2d;
    WeightedMean corr_3d;
    WeightedMean stretch;
    for (const std::size_t i : drawn)
    {
        Columns picture;
        picture.add(pictures[i]);
        const CircleStatistics own = picture.statistics();
        const auto weight = static_cast<double>(pictures[i].size());
        corr_2d.add(own.corr_2d, weight);
        corr_3d.add(own.corr_3d, weight);
        stretch.add(own.stretch, weight);
    }
    return {corr_2d.value(), corr_3d.value(), stretch.value()};
}

CircleFigures circle_figures(const std::vector<std::vector<Circle>>& pictures, Protocol protocol,
                             const evaluation::Bootstrap& bootstrap)
{
    CircleFigures figures;
    for (const auto& picture : pictures)
        for (const Circle& circle : picture)
        {
            ++figures.circles;
            figures.circles_3d += circle.world ? 1 : 0;
        }
    std::vector<std::size_t> all(pictures.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    figures.value = circle_statistics(pictures, all, protocol);
    const auto interval = [&](double CircleStatistics::*member)
    {
        const auto drawn_statistic = [&](std::span<const std::size_t> drawn)
        { return circle_statistics(pictures, drawn, protocol).*member; };
        return evaluation::bootstrap_interval(pictures.size(), drawn_statistic, bootstrap);
    };
    figures.corr_2d = interval(&CircleStatistics::corr_2d);
    figures.corr_3d = interval(&CircleStatistics::corr_3d);
    figures.stretch = interval(&CircleStatistics::stretch);
    return figures;
}

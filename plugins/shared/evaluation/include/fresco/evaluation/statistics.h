#pragma once

#include <fresco/artifact.h>
#include <fresco/files.h>
#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

/// \file What the evaluating stages compute and write alike: means, correlations, intervals, and the file of figures.

namespace fresco::evaluation
{

/// Arithmetic mean; NaN of nothing. Summed in order, so that equal inputs give equal bits.
double mean(std::span<const double> values);

/// Pearson's correlation coefficient of pairs (x[i], y[i]). NaN for fewer than two pairs or where x or y does not vary.
/// \pre x and y have one length.
double pearson(std::span<const double> x, std::span<const double> y);

struct Interval
{
    double low = 0;
    double high = 0;
};

struct Bootstrap
{
    int resamples;
    std::uint64_t seed;
};

/// Enough draws for the interval's ends to be stable in their third digit; the seed makes them repeatable.
inline constexpr Bootstrap usual_bootstrap{.resamples = 2000, .seed = 1};

/// A statistic of some of the groups (frames), given as indices below the number of groups; one may occur several times.
using GroupStatistic = std::function<double(std::span<const std::size_t>)>;

/// 95 % percentile interval of a statistic when whole groups are drawn with replacement: Efron, "Bootstrap methods: another look
/// at the jackknife" (1979). Draws depend only on the seed. Draws for which the statistic is NaN are left out; both ends are NaN
/// where more than half of the draws are, or there are fewer than two groups.
Interval bootstrap_interval(std::size_t groups, const GroupStatistic& statistic, const Bootstrap& bootstrap);

/// The interval of the mean of one value per group.
Interval bootstrap_mean(std::span<const double> values, const Bootstrap& bootstrap);

/// A figure with its interval as a map {value, low, high}; what is not finite becomes null, which JSON has.
Value figure(double value, Interval interval);
Value number_or_null(double value);

/// "0.0123 [0.0118, 0.0127]", four digits each, in any locale; "undefined" for what is not finite.
std::string figure_text(double value, Interval interval);

/// Writes figures as JSON to `path` below the folder of an output, and returns the output's value.
Files write_figures(const ArtifactFolder& folder, const std::string& path, const Value& figures);

}  // namespace fresco::evaluation

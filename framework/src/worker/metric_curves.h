#pragma once

#include <fresco/value.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fresco::host
{

/// How the running figures of a stage went, from what it says with metric and progress; thinned evenly where there are many
/// points.
class MetricCurves
{
  public:
    static constexpr std::size_t most_points = 600;  ///< Beyond that, every second one goes.

    struct Point
    {
        double done = 0;
        Value metrics;  ///< Name -> number, or null where it was not finite.
    };

    /// The figures at `done`. Where a stage goes back to an earlier place, what was there goes. True if the point was kept.
    bool add(double done, const Value& metrics);
    /// {unit, done: [...], metrics: {name: [...]}}, null where a figure was not known yet; null if nothing was reported.
    Value to_value(std::string_view unit) const;
    const std::vector<Point>& points() const { return points_; }

    /// A line, with its checksum, of a file that takes the curves over a killed run.
    static std::string line(double done, const Value& metrics);
    /// Those lines of such a file that are whole; none where there is no file.
    void load(const std::filesystem::path& file);

  private:
    void thin();

    std::vector<Point> points_;
    double least_step_ = 0;
};

}  // namespace fresco::host

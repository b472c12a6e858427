#include "worker/metric_curves.h"

#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>

#include <algorithm>
#include <sstream>

namespace fresco::host
{
namespace
{
constexpr std::size_t checksum_digits = 32;
}

bool MetricCurves::add(double done, const Value& metrics)
{
    if (!metrics.is_map() || metrics.as_map().empty())
        return false;
    while (!points_.empty() && points_.back().done >= done)
        points_.pop_back();
    if (!points_.empty() && done - points_.back().done < least_step_)
        return false;
    points_.push_back({done, metrics});
    if (points_.size() > most_points)
        thin();
    return true;
}

void MetricCurves::thin()
{
    // A little less than twice the step, so that rounding takes no third point.
    least_step_ = 1.999 * (points_.back().done - points_.front().done) / static_cast<double>(points_.size() - 1);
    std::vector<Point> kept;
    for (Point& point : points_)
        if (kept.empty() || point.done - kept.back().done >= least_step_)
            kept.push_back(std::move(point));
    points_ = std::move(kept);
}

Value MetricCurves::to_value(std::string_view unit) const
{
    if (points_.empty())
        return {};
    std::vector<std::string> names;
    for (const Point& point : points_)
        for (const auto& [name, value] : point.metrics.as_map())
            if (std::ranges::find(names, name) == names.end())
                names.push_back(name);
    Value::List done;
    for (const Point& point : points_)
        done.emplace_back(point.done);
    Value::Map metrics;
    for (const std::string& name : names)
    {
        Value::List values;
        for (const Point& point : points_)
        {
            const Value* value = point.metrics.find(name);
            values.push_back(value != nullptr ? *value : Value());
        }
        metrics.emplace_back(name, std::move(values));
    }
    return Value::Map{{"unit", unit}, {"done", std::move(done)}, {"metrics", std::move(metrics)}};
}

std::string MetricCurves::line(double done, const Value& metrics)
{
    const std::string text = to_json(Value::Map{{"done", done}, {"metrics", metrics}});
    return content_hash(text) + text + "\n";
}

void MetricCurves::load(const std::filesystem::path& file)
{
    std::istringstream lines;
    if (is_file(file))
        lines.str(read_text_file(file));
    for (std::string text; std::getline(lines, text);)
    {
        const std::string point = text.substr(std::min(text.size(), checksum_digits));
        if (!text.starts_with(content_hash(point)))
            continue;  // Damaged, or the line that a killed run was writing.
        const Value value = parse_json(point);
        add(value.at("done").as_double(), value.at("metrics"));
    }
}

}  // namespace fresco::host

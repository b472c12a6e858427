#pragma once

#include <fresco/value.h>

#include <string>
#include <vector>

namespace fresco::host
{

/// Round numbers within [low, high], about `count` of them, ascending.
std::vector<double> round_ticks(double low, double high, int count);

/// One chart per metric of what MetricCurves::to_value gives, as SVG elements; empty where there is nothing to draw. Logarithmic
/// where the values are positive and the largest is more than thirty times the smallest.
std::string curve_charts(const Value& curves);

/// What a stage reports as "judged_frames" — {measure, least, names, values, kept} — as an SVG element with a bar per frame (per
/// few frames, the one that is largest, beyond a thousand). Empty where it has not this form.
std::string frames_chart(const Value& judged);

}  // namespace fresco::host

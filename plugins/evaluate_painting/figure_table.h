#pragma once

#include <fresco/value.h>

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// \file Figures with their wanted ranges, as the stage's log, its JSON file and the report's table show them.

/// The range that a figure should lie in, its ends included.
struct Wanted
{
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();

    bool holds(double value) const { return value >= low && value <= high; }
    /// How far a value lies outside the range; negative inside. Larger is worse.
    double badness(double value) const;
    /// "at most 0.005", "0.8 to 1.2"
    std::string text() const;
};

/// A figure of the painting, and its wanted range.
struct Figure
{
    struct Worst
    {
        double value = 0;
        std::string view;
    };

    std::string name;
    double value = 0;            ///< The mean, for a figure over views.
    std::optional<Worst> worst;  ///< Only for a figure over views.
    Wanted wanted;

    bool is_inside() const { return wanted.holds(value); }
};

/// Mean and worst of one value per view. Values that are not finite are left out; nullopt if none is left.
std::optional<Figure> over_views(const std::string& name, Wanted wanted, std::span<const double> values,
                                 std::span<const std::string> views);

/// Three significant digits, in any locale.
std::string digits(double value);

/// For people: {"columns": […], "rows": [[…], …]}, all texts.
fresco::Value table(const std::vector<Figure>& figures);
/// For programs: a map by name.
fresco::Value figures_value(const std::vector<Figure>& figures);
/// "coherence 0.91, strokes 0.7"
std::string values_line(const std::vector<Figure>& figures);
/// "1 of 2 figures in the wanted range; strokes 0.4 (wanted at least 0.65)"
std::string ranges_line(const std::vector<Figure>& figures);

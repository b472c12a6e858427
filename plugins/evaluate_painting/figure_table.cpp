#include "figure_table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

using fresco::Value;

double Wanted::badness(double value) const
{
    return std::max(low - value, value - high);
}

std::string Wanted::text() const
{
    if (std::isinf(low))
        return "at most " + digits(high);
    return std::isinf(high) ? "at least " + digits(low) : digits(low) + " to " + digits(high);
}

std::optional<Figure> over_views(const std::string& name, Wanted wanted, std::span<const double> values,
                                 std::span<const std::string> views)
{
    Figure figure{name, 0, std::nullopt, wanted};
    double sum = 0;
    double count = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
    {
        if (!std::isfinite(values[i]))
            continue;
        sum += values[i];
        ++count;
        if (!figure.worst || wanted.badness(values[i]) > wanted.badness(figure.worst->value))
            figure.worst = {values[i], views[i]};
    }
    if (count == 0)
        return std::nullopt;
    figure.value = sum / count;
    return figure;
}

std::string digits(double value)
{
    return fmt::format("{:.3g}", value);
}

Value table(const std::vector<Figure>& figures)
{
    Value::List rows;
    for (const Figure& figure : figures)
        rows.push_back(Value::List{figure.name, digits(figure.value), figure.worst ? digits(figure.worst->value) : "",
                                   figure.worst ? figure.worst->view : "", figure.wanted.text(),
                                   figure.is_inside() ? "yes" : "no"});
    return Value::Map{{"columns", Value::List{"figure", "mean", "worst", "worst view", "wanted", "reached"}},
                      {"rows", std::move(rows)}};
}

Value figures_value(const std::vector<Figure>& figures)
{
    Value::Map all;
    for (const Figure& figure : figures)
    {
        Value::Map entry{{figure.worst ? "mean" : "value", figure.value}};
        if (figure.worst)
        {
            entry.emplace_back("worst", figure.worst->value);
            entry.emplace_back("worst_view", figure.worst->view);
        }
        if (std::isfinite(figure.wanted.low))
            entry.emplace_back("at_least", figure.wanted.low);
        if (std::isfinite(figure.wanted.high))
            entry.emplace_back("at_most", figure.wanted.high);
        entry.emplace_back("reached", figure.is_inside());
        all.emplace_back(figure.name, std::move(entry));
    }
    return all;
}

std::string values_line(const std::vector<Figure>& figures)
{
    std::string text;
    for (const Figure& figure : figures)
        text += (text.empty() ? "" : ", ") + figure.name + " " + digits(figure.value);
    return text;
}

std::string ranges_line(const std::vector<Figure>& figures)
{
    std::vector<Figure> missed;
    std::ranges::copy_if(figures, std::back_inserter(missed), [](const Figure& figure) { return !figure.is_inside(); });
    std::string text = fmt::format("{} of {} figures in the wanted range", figures.size() - missed.size(), figures.size());
    for (const Figure& figure : missed)
        text += (figure.name == missed.front().name ? "; " : ", ") + figure.name + " " + digits(figure.value) + " (wanted " +
                figure.wanted.text() + ")";
    return text;
}

#include "report/report_figures.h"
#include "base/unit_text.h"

#include <fresco/html.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace fresco::host
{
namespace
{

constexpr std::string_view thin_space = "\u202f";
constexpr std::string_view before_ending = "_before";
constexpr std::string_view after_ending = "_after";

std::string grouped(std::int64_t number)
{
    const auto bits = static_cast<std::uint64_t>(number);
    const std::string digits = std::to_string(number < 0 ? 0 - bits : bits);
    std::string text = number < 0 ? "−" : "";
    for (std::size_t i = 0; i < digits.size(); ++i)
    {
        if (i > 0 && (digits.size() - i) % 3 == 0 && digits.size() > 4)
            text += thin_space;
        text += digits[i];
    }
    return text;
}

std::string significant(double number)
{
    if (number == std::floor(number) && std::abs(number) < 1e15)
        return grouped(static_cast<std::int64_t>(number));
    if (std::abs(number) >= 1000 && std::abs(number) < 1e15)
        return grouped(static_cast<std::int64_t>(std::llround(number)));
    std::string text = fmt::format("{:.4g}", number);
    if (text.front() == '-')
        text.replace(0, 1, "−");
    return text;
}

struct Unit
{
    std::string_view ending;
    std::string_view shown;
};
constexpr std::array<Unit, 8> units{
    {{"_m2", "m²"}, {"_m", "m"}, {"_cm", "cm"}, {"_mm", "mm"}, {"_px", "px"}, {"_deg", "°"}, {"_s", "s"}, {"_mb", "MB"}}};

/// "largest_angle_deg", 70 -> "largest angle", "70 °".
std::pair<std::string, std::string> named(std::string_view name, const Value& value)
{
    std::string_view bare = name;
    std::string text;
    const bool rate = name.find("_per_") != std::string_view::npos;
    if (value.is_string())
        text = value.as_string();
    else if (value.is_bool())
        text = value.as_bool() ? "yes" : "no";
    else if (value.is_null())
        text = "not finite";
    else if (name.ends_with("_share"))
    {
        bare.remove_suffix(std::string_view("_share").size());
        text = fmt::format("{:.4g} %", 100 * value.as_double());
    }
    else if (name == "bytes" || name.ends_with("_bytes"))
        text = bytes_text(value.as_double());
    else if (name == "seconds" || name.ends_with("_seconds"))
        text = duration_text(value.as_double());
    else
    {
        text = figure_text(value);
        const auto unit = std::ranges::find_if(units, [&](const Unit& each) { return !rate && name.ends_with(each.ending); });
        if (unit != units.end())
        {
            bare.remove_suffix(unit->ending.size());
            text += " " + std::string(unit->shown);
        }
    }
    std::string label(bare.empty() ? name : bare);
    std::ranges::replace(label, '_', ' ');
    return {std::move(label), std::move(text)};
}

std::string change_text(const Value& before, const Value& after)
{
    if (!before.is_number() || !after.is_number() || before.as_double() == 0 || before == after)
        return "";
    const double factor = after.as_double() / before.as_double();
    if (factor >= 3)
        return fmt::format("×{:.3g}", factor);
    return (factor < 1 ? "−" : "+") + fmt::format("{:.3g} %", std::abs(100 * (factor - 1)));
}

void collect(std::string_view prefix, const Value& report, std::vector<ReportFigure>& figures)
{
    for (const auto& [name, value] : report.as_map())
    {
        if (value.is_list())
            continue;
        if (value.is_map())
        {
            collect(std::string(prefix) + name + "_", value, figures);
            continue;
        }
        std::string_view bare = name;
        if (name.ends_with(before_ending))
        {
            bare.remove_suffix(before_ending.size());
            if (report.find(std::string(bare) + std::string(after_ending)) != nullptr)
                continue;  // Told with what came after.
            bare = name;
        }
        const Value* before = nullptr;
        if (name.ends_with(after_ending))
        {
            bare.remove_suffix(after_ending.size());
            before = report.find(std::string(bare) + std::string(before_ending));
            if (before == nullptr)
                bare = name;
        }
        auto [label, text] = named(std::string(prefix) + std::string(bare), value);
        ReportFigure figure{std::move(label), std::move(text), "", ""};
        if (before != nullptr)
        {
            figure.before = named(bare, *before).second;
            figure.change = change_text(*before, value);
        }
        figures.push_back(std::move(figure));
    }
}

/// A row of a table: texts as they are, numbers as in figures.
std::string cells(std::string_view element, const Value& row)
{
    std::string text;
    for (const Value& value : row.as_list())
    {
        const std::string shown = value.is_number() ? figure_text(value) : value.is_string() ? value.as_string() : "";
        text += fmt::format("<{0}{1}>{2}</{0}>", element, value.is_number() ? " class=\"number\"" : "", html_escaped(shown));
    }
    return text;
}

}  // namespace

std::string figure_text(const Value& number)
{
    return number.is_int() ? grouped(number.as_int()) : significant(number.as_double());
}

std::string bytes_text(double bytes)
{
    if (bytes < 1000)
        return fmt::format("{:.0f} bytes", bytes);
    if (bytes < 1e6)
        return fmt::format("{:.1f} kB", bytes / 1e3);
    return bytes < 1e9 ? fmt::format("{:.1f} MB", bytes / 1e6) : fmt::format("{:.1f} GB", bytes / 1e9);
}

std::string report_table(const Value& report)
{
    const Value* table = report.find("table");
    const Value* columns = table != nullptr ? table->find("columns") : nullptr;
    const Value* rows = table != nullptr ? table->find("rows") : nullptr;
    if (columns == nullptr || rows == nullptr || !columns->is_list() || !rows->is_list() || rows->as_list().empty())
        return "";
    std::string text = "<div class=\"scroll\"><table><tr>" + cells("th", *columns) + "</tr>\n";
    for (const Value& row : rows->as_list())
        if (row.is_list())
            text += "<tr>" + cells("td", row) + "</tr>\n";
    return text + "</table></div>\n";
}

std::vector<ReportFigure> report_figures(const Value& report)
{
    std::vector<ReportFigure> figures;
    if (!report.is_map())
        return figures;
    // Judged frames and tables are shown on their own, not listed.
    Value::Map plain;
    for (const auto& [name, value] : report.as_map())
        if (name != "judged_frames" && name != "table")
            plain.emplace_back(name, value);
    collect("", Value(std::move(plain)), figures);
    return figures;
}

}  // namespace fresco::host

#include "report/sweep_page.h"
#include "base/unit_text.h"

#include <fresco/html.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>

namespace fresco::host
{
namespace
{

constexpr const char* style = R"(
:root { color-scheme: light dark; --line: #8884; --faint: #888; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; padding: 0 1.5rem; max-width: 110rem; }
h1 { font-size: 1.4rem; margin: 0 0 .2rem; }
h2 { font-size: 1.1rem; margin: 2rem 0 .6rem; }
p.about, .meta, summary { color: var(--faint); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; }
th { text-align: left; font-weight: 600; padding: .4rem .6rem; white-space: nowrap; }
tbody th { vertical-align: top; position: sticky; left: 0; background: Canvas; }
td { vertical-align: top; padding: .4rem; border: 1px solid var(--line); }
.cards { display: flex; flex-wrap: wrap; gap: 1rem; }
.cards article { border: 1px solid var(--line); border-radius: 6px; padding: .6rem; }
h3 { font-size: 1rem; margin: 0 0 .4rem; }
.pictures { display: flex; gap: .3rem; }
img { display: block; width: 20rem; max-width: 100%; height: auto; border-radius: 3px; }
.many img { width: 13rem; }
.state { font-weight: 600; }
.failed { color: #c33; }
.none { width: 12rem; padding: 2rem 1rem; text-align: center; color: var(--faint); border: 1px dashed var(--line); }
pre { white-space: pre-wrap; max-width: 40rem; font-size: .85rem; margin: .4rem 0; }
ul { margin: .2rem 0; padding-left: 1.2rem; }
)";

/// Of a path, for an attribute: what has a meaning in an address written as %XX.
std::string address(const std::string& path)
{
    std::string text;
    for (const char c : path)
    {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                           std::string_view("-_.~/,=+@").find(c) != std::string_view::npos;
        text += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return text;
}

std::string link(const std::string& file, const std::string& inner)
{
    return "<a href=\"" + address(file) + "\">" + inner + "</a>";
}

std::string cell_html(const SweepCell& cell)
{
    std::string html;
    if (cell.pictures.empty())
        html += "<div class=\"none\">no picture</div>";
    else
        html += cell.pictures.size() > 1 ? "<div class=\"pictures many\">" : "<div class=\"pictures\">";
    for (const SweepPicture& picture : cell.pictures)
        html += link(picture.file, "<img loading=\"lazy\" alt=\"" + html_escaped(picture.file) + "\" src=\"" +
                                       (picture.uri.empty() ? address(picture.file) : picture.uri) + "\">");
    html += cell.pictures.empty() ? "" : "</div>";
    html += "<div class=\"meta\"><span class=\"state" + std::string(cell.state == "failed" ? " failed" : "") + "\">" +
            html_escaped(cell.state) + "</span>";
    if (cell.seconds > 0)
        html += " · " + duration_text(cell.seconds);
    if (!cell.report.empty())
        html += " · " + link(cell.report, "report");
    html += "</div>";
    if (!cell.error.empty())
        html += "<pre>" + html_escaped(cell.error) + "</pre>";
    if (!cell.files.empty())
    {
        html += fmt::format("<details><summary>{} file{}</summary><ul>", cell.files.size(), cell.files.size() == 1 ? "" : "s");
        constexpr std::size_t most_files = 60;
        for (std::size_t i = 0; i < std::min(most_files, cell.files.size()); ++i)
            html += "<li>" + link(cell.files[i], html_escaped(cell.files[i])) + "</li>";
        if (cell.files.size() > most_files)
            html += fmt::format("<li>and {} more</li>", cell.files.size() - most_files);
        html += "</ul></details>";
    }
    return html;
}

/// In the order in which they come.
std::vector<std::string> values_of(const std::vector<const SweepCell*>& cells, std::size_t axis)
{
    std::vector<std::string> values;
    for (const SweepCell* cell : cells)
        if (std::find(values.begin(), values.end(), cell->values[axis]) == values.end())
            values.push_back(cell->values[axis]);
    return values;
}

/// "size=2048" names its axis itself.
std::string named_value(const std::string& axis, const std::string& value)
{
    return value.starts_with(axis + "=") ? value : axis + ": " + value;
}

std::string cards_html(const std::vector<const SweepCell*>& cells)
{
    std::string html = "<div class=\"cards\">\n";
    for (const SweepCell* cell : cells)
        html += "<article><h3>" + html_escaped(cell->name) + "</h3>" + cell_html(*cell) + "</article>\n";
    return html + "</div>\n";
}

/// Rows are the values of the axis before the last, columns those of the last.
std::string table_html(const SweepPage& page, const std::vector<const SweepCell*>& cells)
{
    const std::size_t column = page.axes.size() - 1;
    const std::size_t row = column - 1;
    std::string html = "<div class=\"scroll\"><table><thead><tr><th>" + html_escaped(page.axes[row]) + " \\ " +
                       html_escaped(page.axes[column]) + "</th>";
    for (const std::string& value : values_of(cells, column))
        html += "<th>" + html_escaped(value) + "</th>";
    html += "</tr></thead><tbody>\n";
    for (const std::string& value : values_of(cells, row))
    {
        html += "<tr><th>" + html_escaped(value) + "</th>";
        for (const SweepCell* cell : cells)
            if (cell->values[row] == value)
                html += "<td>" + cell_html(*cell) + "</td>\n";
        html += "</tr>\n";
    }
    return html + "</tbody></table></div>\n";
}

}  // namespace

std::string sweep_html(const SweepPage& page)
{
    std::map<std::string, std::size_t> states;
    for (const SweepCell& cell : page.cells)
        ++states[cell.state];
    std::string about = fmt::format("{} combination{}", page.cells.size(), page.cells.size() == 1 ? "" : "s");
    for (const auto& [state, count] : states)
        about += fmt::format(" · {} {}", count, state);
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                       "<meta name=\"viewport\" content=\"width=device-width\">\n<title>" +
                       html_escaped(page.title) + "</title>\n<style>" + style + "</style></head><body>\n<h1>" +
                       html_escaped(page.title) + "</h1>\n<p class=\"about\">" + html_escaped(about) + "</p>\n";
    if (!page.note.empty())
        html += "<p class=\"about\">" + html_escaped(page.note) + "</p>\n";
    // The axes before the last two make sections.
    const std::size_t outer = page.axes.size() > 2 ? page.axes.size() - 2 : 0;
    for (std::size_t begin = 0; begin < page.cells.size();)
    {
        std::vector<const SweepCell*> cells;
        const auto& first = page.cells[begin].values;
        for (; begin < page.cells.size() &&
               std::equal(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(outer), page.cells[begin].values.begin());
             ++begin)
            cells.push_back(&page.cells[begin]);
        std::string heading;
        for (std::size_t axis = 0; axis < outer; ++axis)
            heading += (heading.empty() ? "" : ", ") + named_value(page.axes[axis], first[axis]);
        html += heading.empty() ? "" : "<h2>" + html_escaped(heading) + "</h2>\n";
        html += page.axes.size() > 1 ? table_html(page, cells) : cards_html(cells);
    }
    return html + "</body></html>\n";
}

}  // namespace fresco::host

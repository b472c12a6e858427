#include "base/unit_text.h"
#include "report/report_charts.h"
#include "report/report_figures.h"
#include "report/report_graph.h"
#include "report/report_model.h"
#include "report/report_parts.h"

#include <fresco/html.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::host
{
namespace
{

constexpr std::string_view three_license =
    R"(/* three.js and its OrbitControls, copyright three.js authors, under the MIT license: Permission is hereby granted, free of charge, to any
person obtaining a copy of this software and associated documentation files (the "Software"), to deal in the Software without restriction,
including without limitation the rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to
permit persons to whom the Software is furnished to do so, subject to the following conditions: The above copyright notice and this permission
notice shall be included in all copies or substantial portions of the Software. THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND,
EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO
EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE. */
)";

std::string heading(const ReportModel& model)
{
    const auto count = [&](auto matches) { return std::ranges::count_if(model.stages, matches); };
    const auto ran = count([](const ReportStage& stage) { return stage.state == "ran"; });
    const auto stored = count([](const ReportStage& stage) { return stage.state == "stored" || stage.state == "not needed"; });
    const auto failed = count([](const ReportStage& stage) { return stage.state == "failed"; });
    std::string text = fmt::format("<h1>{}: <span class=\"{}\">{}</span></h1>\n<p>{} of {} stages ran, {} were stored already",
                                   html_escaped(model.pipeline), model.outcome == "done" ? "good" : "bad",
                                   html_escaped(model.outcome), ran + failed, model.stages.size(), stored);
    if (failed > 0)
        text += fmt::format(", {} failed", failed);
    text += fmt::format("; {} on {} {}.</p>\n<p class=\"soft\">{} · {} · {}</p>\n", duration_text(model.seconds), model.cores,
                        model.cores == 1 ? "core" : "cores", html_escaped(model.time), html_escaped(model.program),
                        html_escaped(model.processor));
    for (const ReportStage& stage : model.stages)
        if (!stage.error.empty())
            text += "<div class=\"error\">" + html_escaped(stage.error) + "</div>\n";
    return text;
}

std::string room_section(const ReportMedia& media)
{
    if (media.room.empty())
        return "";
    const ReportRoom& room = media.room.front();
    std::string text = "<section><h2>The room</h2>\n";
    if (report_three_js.empty())
        return text + "<p class=\"note\">To turn the room around here, build fresco where three.js is (Debian's "
                      "libjs-three).</p></section>\n";
    text += "<div id=\"room\"><p class=\"soft\">Drag: turn · right button: move · wheel: nearer and farther</p></div>\n"
            "<div class=\"bar\"><button id=\"inside\">Stand inside</button><button id=\"outside\">Look from outside</button>";
    return text + fmt::format("<span class=\"soft\">{} faces of {}, positions to {:.2g} mm</span></div></section>\n",
                              figure_text(Value(room.triangles)), html_escaped(room.stage),
                              1000 * *std::ranges::max_element(room.extent) / 65535);
}

std::string views_section(const ReportMedia& media)
{
    if (media.views.empty())
        return "";
    std::string text =
        "<section><h2>Camera and render</h2>\n<div class=\"compare\"><img alt=\"camera picture\"><img class=\"over\" "
        "alt=\"render\">"
        "<input type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"0.1\" aria-label=\"How much of the camera picture is "
        "shown\">"
        "<span class=\"edge\"></span><span class=\"tag left\">camera</span><span class=\"tag right\">render</span></div>\n"
        "<div class=\"bar\"><span id=\"view-name\"></span>";
    if (!media.room.empty() && !report_three_js.empty())
        text += "<button id=\"stand-here\">Stand here in the room</button>";
    text += "</div>\n<div class=\"thumbs\">";
    for (const ReportView& view : media.views)
        text += "<button title=\"" + html_escaped(view.name) + "\"><img alt=\"" + html_escaped(view.name) + "\"></button>";
    return text + "</div></section>\n";
}

std::string picture_element(const ReportPicture& picture)
{
    const std::string name = html_escaped(picture.name);
    return "<figure>" +
           (picture.video ? "<video controls loop muted src=\"" + picture.uri + "\"></video>"
                          : "<img src=\"" + picture.uri + "\" alt=\"" + name + "\">") +
           "<figcaption>" + name + "</figcaption></figure>\n";
}

std::string pictures_sections(const ReportMedia& media)
{
    std::string text;
    if (!media.atlas.empty())
    {
        text += "<section><h2>The atlas</h2>\n<div class=\"atlas\">";
        for (const ReportPicture& picture : media.atlas)
            text += picture_element(picture);
        text += "</div></section>\n";
    }
    if (media.pictures.empty())
        return text;
    text += "<section><h2>Other pictures</h2>\n<div class=\"pictures\">";
    for (const ReportPicture& picture : media.pictures)
        text += picture_element(picture);
    return text + "</div></section>\n";
}

std::string frames_section(const ReportModel& model)
{
    std::string text;
    for (const ReportStage& stage : model.stages)
        if (const Value* judged = stage.report.find("judged_frames"); judged != nullptr)
            if (const std::string chart = frames_chart(*judged); !chart.empty())
                text += "<h3>" + html_escaped(stage.name) + "</h3>\n" + chart;
    return text.empty() ? text : "<section><h2>Frames kept and dropped</h2>\n" + text + "</section>\n";
}

std::string curves_section(const ReportModel& model)
{
    std::string text;
    for (const ReportStage& stage : model.stages)
        if (const std::string charts = curve_charts(stage.curves); !charts.empty())
            text += "<h3>" + html_escaped(stage.name) + "</h3>\n<div class=\"charts\">" + charts + "</div>\n";
    return text.empty() ? text : "<section><h2>How it went</h2>\n" + text + "</section>\n";
}

std::string figures_list(const Value& report)
{
    const auto figures = report_figures(report);
    if (figures.empty())
        return "";
    std::string text = "<dl>";
    for (const ReportFigure& figure : figures)
    {
        text += "<div><dt>" + html_escaped(figure.label) + "</dt><dd>";
        if (!figure.before.empty())
            text += html_escaped(figure.before) + " → ";
        text += html_escaped(figure.value);
        if (!figure.change.empty())
            text += " <span class=\"change\">" + html_escaped(figure.change) + "</span>";
        text += "</dd></div>\n";
    }
    return text + "</dl>\n";
}

std::string messages_list(const Value& messages)
{
    std::string text;
    if (!messages.is_list())
        return text;
    for (const Value& message : messages.as_list())
        if (message.is_map())
            for (const auto& [kind, said] : message.as_map())
                if (said.is_string())
                    text += fmt::format("<p class=\"{}\">{}{}</p>\n", kind == "warning" ? "bad" : "soft",
                                        kind == "warning" ? "warning: " : "", html_escaped(said.as_string()));
    return text;
}

std::string options_list(const Value& options)
{
    if (!options.is_map() || options.as_map().empty())
        return "";
    std::string text = "<details><summary>options</summary><dl>";
    for (const auto& [name, value] : options.as_map())
        text += "<div><dt>" + html_escaped(name) + "</dt><dd><code>" +
                html_escaped(value.is_string() ? value.as_string() : to_json(value)) + "</code></dd></div>\n";
    return text + "</dl></details>\n";
}

std::string cost_text(const ReportStage& stage)
{
    std::string text = stage.state;
    if (stage.seconds > 0)
        text += (stage.ran() ? " in " : ", made in ") + duration_text(stage.seconds);
    if (stage.memory_mb > 0)
        text += ", " + size_text(stage.memory_mb) + " of memory";
    if (stage.disk_mb > 0)
        text += ", " + size_text(stage.disk_mb) + " stored";
    return text;
}

std::string stages_section(const ReportModel& model)
{
    std::string text = "<section><h2>Stage by stage</h2>\n";
    for (std::size_t i = 0; i < model.stages.size(); ++i)
    {
        const ReportStage& stage = model.stages[i];
        text += fmt::format("<article class=\"stage\" id=\"stage-{}\"><header><h3>{}</h3><code class=\"soft\">{}</code><span "
                            "class=\"cost\">{}</span></header>\n"
                            "<p class=\"soft\">{}</p>\n",
                            i, html_escaped(stage.name), html_escaped(stage.type), html_escaped(cost_text(stage)),
                            html_escaped(stage.help));
        text += messages_list(stage.messages) + report_table(stage.report) + figures_list(stage.report) +
                options_list(stage.options) + "</article>\n";
    }
    return text + "</section>\n";
}

/// A path as a relative URL.
std::string url_path(const std::string& path)
{
    std::string text;
    for (const char c : path)
    {
        const auto byte = static_cast<unsigned char>(c);
        const bool plain =
            byte < 0x80 && (std::isalnum(byte) != 0 || std::string_view("/._-~").find(c) != std::string_view::npos);
        text += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
    }
    return "./" + text;
}

std::string files_section(const ReportModel& model)
{
    if (model.files.empty())
        return "";
    constexpr std::size_t shown = 200;
    std::string text =
        "<section><h2>Files</h2>\n<div class=\"scroll\"><table><tr><th>file</th><th>stage</th><th>size</th></tr>\n";
    for (std::size_t i = 0; i < std::min(shown, model.files.size()); ++i)
    {
        const ReportFile& file = model.files[i];
        text +=
            fmt::format("<tr><td><a href=\"{}\">{}</a></td><td>{}</td><td class=\"number\">{}</td></tr>\n", url_path(file.name),
                        html_escaped(file.name), html_escaped(file.stage), bytes_text(static_cast<double>(file.bytes)));
    }
    text += "</table></div>\n";
    if (model.files.size() > shown)
        text += fmt::format("<p class=\"soft\">… and {} more</p>\n", model.files.size() - shown);
    return text + "</section>\n";
}

Value triple(const std::array<double, 3>& values)
{
    return Value::List{values[0], values[1], values[2]};
}

/// What the page's script works with.
Value script_data(const ReportMedia& media)
{
    Value::List views;
    for (const ReportView& view : media.views)
        views.push_back(Value::Map{{"name", view.name}, {"camera", view.camera}, {"render", view.render}, {"pose", view.pose}});
    Value room;
    if (!media.room.empty())
    {
        const ReportRoom& shown = media.room.front();
        room = Value::Map{{"vertices", shown.vertices},
                          {"triangles", shown.triangles},
                          {"low", triple(shown.low)},
                          {"extent", triple(shown.extent)},
                          {"start", shown.start}};
    }
    return Value::Map{{"views", std::move(views)}, {"room", std::move(room)}};
}

std::string scripts(const ReportMedia& media)
{
    std::string text = "<script type=\"application/json\" id=\"report-data\">" + script_json(script_data(media)) + "</script>\n";
    if (!media.room.empty() && !report_three_js.empty())
    {
        const ReportRoom& room = media.room.front();
        text += "<script type=\"text/plain\" id=\"room-geometry\">" + room.geometry + "</script>\n";
        text += "<script type=\"text/plain\" id=\"room-texture\">" + room.texture + "</script>\n";
        text += "<script>" + std::string(three_license) + std::string(report_three_js) + "</script>\n";
    }
    return text + "<script>" + std::string(report_js) + "</script>\n";
}

}  // namespace

std::string report_page(const ReportModel& model, const ReportMedia& media)
{
    std::string page = report_mark(model.signature);
    page += "<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\n<link "
            "rel=\"icon\" href=\"data:,\">\n<title>" +
            html_escaped(model.pipeline) + " · fresco</title>\n<style>" + std::string(report_css) + "</style></head><body>\n";
    page += heading(model);
    for (const std::string& note : media.notes)
        page += "<p class=\"note\">" + html_escaped(note) + "</p>\n";
    page += "<section><h2>The pipeline</h2>\n<div class=\"scroll\">" + graph_svg(model.stages) + "</div></section>\n";
    page += room_section(media) + views_section(media) + pictures_sections(media);
    page += frames_section(model) + curves_section(model) + stages_section(model) + files_section(model);
    page += scripts(media) + "</body></html>\n";
    return page;
}

}  // namespace fresco::host

#include "report/page.h"
#include "base/common.h"
#include "base/text.h"

#include "base/machine.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <fstream>
#include <thread>

namespace fresco::host
{
namespace
{

constexpr std::string_view html_begin = "<!doctype html><!-- fresco ";
constexpr std::string_view json_begin = "{\n\"format\": \"fresco-";

/// The page fetches and runs only its own contents, and shows pictures beside it.
constexpr std::string_view policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                                    "img-src data: blob: file: 'self'; media-src data:";

std::string mark(const std::string& signature)
{
    return std::string(html_begin) + signature + " -->\n";
}

bool begins_with(const fs::path& file, std::string_view text)
{
    std::string begin(text.size(), '\0');
    std::ifstream stream(file, std::ios::binary);
    return stream.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == text;
}

/// A line per entry, and per item of a list of maps: for people and for tools that work by lines.
std::string json_lines(const Value& data)
{
    std::string text;
    for (const auto& [name, value] : data.as_map())
    {
        text += (text.empty() ? "{\n" : ",\n") + to_json(name) + ": ";
        if (!value.is_list() || value.as_list().empty() || !value.as_list().front().is_map())
        {
            text += to_json(value);
            continue;
        }
        std::string separator = "[\n";
        for (const Value& item : value.as_list())
            text += std::exchange(separator, ",\n") + " " + to_json(item);
        text += "\n]";
    }
    return text + "\n}\n";
}

/// Error text; empty: none.
std::string run_child(const Value& request, const Store& store)
{
    // The lock keeps others from removing results.
    FileLock in_use = store_lock(store);
    while (!enter_store(store, in_use))
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const WorkFolder folder(store);
    const fs::path file = folder.path() / "request.json";
    write_file(file, to_json(request));
    return wait_for_page(start_child({"internal-page", file.string()}), std::chrono::minutes(2));
}

/// Writes the page; returns the error text, or an empty string.
std::string make_html(const Page& page, const Catalog& catalog, const Store& store)
{
    std::string signature = page.signature;
    std::string failed;
    std::string note = page.hurry;
    if (!note.empty())
        signature = "interrupted";
    else if (viewers_of(catalog).as_map().empty())
        note = "There are no pictures: no plugin shows artifacts (view.files and others)";
    else
    {
        failed = run_child(Value::Map{{"html", page.html.string()},
                                      {"signature", signature},
                                      {"data", page.data},
                                      {"store", store.root().string()},
                                      {"previews", page.previews}},
                           store);
        if (failed.empty())
            return "";
        note = "There are no pictures: " + failed;
        signature = "without pictures";
    }
    write_durable_file(page.html, page_html(page.data, {{Value::Map{{"notes", Value::List{note}}}}, {}}, signature));
    return failed.empty() ? "" : page.html.string() + " is without pictures: " + failed;
}

}  // namespace

std::string wait_for_page(const Child& child, std::chrono::milliseconds limit)
{
    std::string last;
    std::string when;
    const HeardEnd end = hear_out(
        child, limit, [&](const std::string& line) { when = " when it showed " + line; },
        [&](const std::string& line) { last = line; });
    const std::string process = "the process that makes them ";
    if (end.timed_out)
        return process + "did not return within " + duration_text(std::chrono::duration<double>(limit).count()) + when;
    if (end.signal != 0)
        return process + "ended by " + signal_text(end.signal) + when;
    if (end.exit_code != 0 && last.empty())
        return process + "ended with code " + std::to_string(end.exit_code) + when;
    return end.exit_code == 0 ? "" : last;
}

Value viewers_of(const Catalog& catalog)
{
    Value viewers{Value::Map{}};
    for (const TypeDescription* type : catalog.types(Viewer::component_kind))
        viewers.set(type->type, Value::Map{{"library", type->library.string()}, {"hash", type->bytes->hash()}});
    return viewers;
}

std::string page_version()
{
    return program_version() + " " + content_hash(std::string(report_css) + std::string(report_js));
}

PageGuard::PageGuard(const RunRequest& run) : hashes(Store(run.store).file_index())
{
    for (const fs::path& file : named_inputs(*run.pipeline))
        inputs.add(file);
}

std::vector<std::string> page_obstacles(const Page& page, PageGuard& guard)
{
    std::vector<std::string> found;
    const OutputRecord record(page.json.parent_path());
    for (const auto& [file, begin] : {std::pair(page.json, json_begin), std::pair(page.html, html_begin)})
    {
        const std::string name = file.filename().string();
        std::string reason = page.replace ? "" : record.obstacle(name, page.owner, guard.hashes);
        if (!page.replace && record.is_unfinished(name) && fs::exists(file) && !begins_with(file, begin))
            reason = "is not in fresco's record of this folder";
        if (is_folder(file))
            found.push_back(file.string() + ": is a folder in place of a file; move it away");
        else if (guard.inputs.find(file))
            found.push_back(file.string() + ": " + input_obstacle);
        else if (!reason.empty())
            found.push_back(file.string() + ": " + reason + "; " + obstacle_advice);
    }
    return found;
}

void check_replaceable(const Page& page, PageGuard& guard, const std::vector<Exporter::File>& exported)
{
    for (const fs::path& file : {page.json, page.html})
        if (const auto own = std::ranges::find(exported, file, &Exporter::File::path); own != exported.end())
            throw Error("the stage " + own->stage + " writes " + file.filename().string() + " itself");
    if (const auto obstacles = page_obstacles(page, guard); !obstacles.empty())
        throw Error(obstacles.front());
}

bool is_current(const Page& page)
{
    return fs::is_regular_file(page.json) && begins_with(page.html, mark(page.signature));
}

void write_data(const Page& page)
{
    make_folder_or(page.json.parent_path(), "choose another with --out");
    const std::string text = json_lines(page.data);
    const std::vector<OutputRecord::NewFile> files{{page.json.filename().string(), content_hash(text)}};
    OutputRecord record(page.json.parent_path());
    FileHashes hashes({});
    record.begin(files, page.owner, hashes);
    write_durable_file(page.json, text);
    record.wrote(files, page.owner);
}

std::string write_html(const Page& page, const Catalog& catalog, const Store& store)
{
    const std::string name = page.html.filename().string();
    OutputRecord record(page.html.parent_path());
    FileHashes hashes({});
    record.begin({{name, ""}}, page.owner, hashes);
    const std::string failed = make_html(page, catalog, store);
    record.wrote({{name, file_hash(page.html)}}, page.owner);
    return failed;
}

std::string page_html(const Value& data, const PageMedia& media, const std::string& signature)
{
    const auto json = [](const char* id, const Value& value)
    { return "<script type=\"application/json\" id=\"" + std::string(id) + "\">" + script_json(value) + "</script>\n"; };
    std::string css(report_css);
    std::string libraries;
    std::string js;
    for (const PageScripts* scripts : media.scripts)
    {
        css += scripts->css;
        libraries += "<script>" + std::string(scripts->library) + "</script>\n";
        js += scripts->js;
    }
    return mark(signature) +
           "<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\n"
           "<meta http-equiv=\"Content-Security-Policy\" content=\"" +
           std::string(policy) + "\">\n<link rel=\"icon\" href=\"data:,\">\n<title>fresco</title>\n<style>" + css +
           "</style></head><body>\n<noscript>This page is drawn by JavaScript, which is switched off here. The same data are in "
           "run.json, or of a matrix in sweep.json, beside it.</noscript>\n<script>document.write('<p "
           "id=\"loading\">Loading…</p>')</script>\n" +
           json("data", data) + json("media", media.entries) + libraries + "<script>\"use strict\";\n" + js +
           std::string(report_js) + "</script>\n</body></html>\n";
}

}  // namespace fresco::host

#include "report/page_child.h"
#include "report/sweep_page.h"

#include "base/machine.h"
#include "report/sweep_summary.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>
#include <fresco/html.h>
#include <fresco/raster.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr const char* page_name = "sweep.html";
constexpr int thumbnail_px = 480;
constexpr int thumbnail_quality = 80;

bool is_picture(const fs::path& file)
{
    const std::string extension = file.extension().string();
    return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

/// What the stages took that are this combination's alone, now or when their results were made.
double own_seconds(const Store& store, const Pipeline& pipeline, const RunSummary& summary, const Combination& combination)
{
    double seconds = 0;
    for (const std::size_t number : combination.stages)
    {
        const PipelineStage& stage = pipeline.stages[number];
        const StageOutcome* outcome = stage.place == combination.name ? summary.outcome_of(stage.name) : nullptr;
        if (outcome == nullptr)
            continue;
        if (outcome->seconds > 0)
            seconds += outcome->seconds;
        else if (!outcome->object.empty() && store.present(outcome->object))
            seconds += store.manifest(outcome->object).at("seconds").as_double();
    }
    return seconds;
}

/// More combinations, fewer pictures of each: the page stays of a size that a browser opens at once.
std::size_t pictures_per_cell(std::size_t cells)
{
    return cells <= 24 ? 3 : cells <= 60 ? 2 : 1;
}

SweepPage page_of(const SweepSummaryRequest& request, const Store& store)
{
    const Pipeline& pipeline = *request.run->pipeline;
    const fs::path& out = request.run->out;
    SweepPage page{pipeline.file.filename().string(), pipeline.sweep.axes, {}, ""};
    for (const CombinationOutcome& outcome : *request.outcomes)
    {
        const auto below = [&](std::size_t file)
        { return request.summary->files[file].path.lexically_relative(out).generic_string(); };
        SweepCell cell{outcome.combination->name,
                       outcome.combination->values,
                       outcome.state,
                       "",
                       own_seconds(store, pipeline, *request.summary, *outcome.combination),
                       "",
                       {},
                       {}};
        if (const StageOutcome* failed = outcome.stage.empty() ? nullptr : request.summary->outcome_of(outcome.stage))
            cell.error = failed->error;
        if (const std::string report = cell.name + "/report.html"; fs::exists(out / report))
            cell.report = report;
        for (const std::size_t file :
             pictures_of(pipeline, *request.summary, outcome, request.pictures, pictures_per_cell(request.outcomes->size())))
            cell.pictures.push_back({below(file), ""});
        for (const std::size_t file : outcome.files)
            cell.files.push_back(below(file));
        page.cells.push_back(std::move(cell));
    }
    return page;
}

Value to_value(const SweepPage& page)
{
    Value::List cells;
    for (const SweepCell& cell : page.cells)
    {
        Value::List pictures;
        for (const SweepPicture& picture : cell.pictures)
            pictures.push_back(picture.file);
        cells.push_back(Value::Map{{"name", cell.name},
                                   {"values", Value::List(cell.values.begin(), cell.values.end())},
                                   {"state", cell.state},
                                   {"error", cell.error},
                                   {"seconds", cell.seconds},
                                   {"report", cell.report},
                                   {"pictures", std::move(pictures)},
                                   {"files", Value::List(cell.files.begin(), cell.files.end())}});
    }
    return Value::Map{
        {"title", page.title}, {"axes", Value::List(page.axes.begin(), page.axes.end())}, {"cells", std::move(cells)}};
}

std::vector<std::string> texts(const Value& list)
{
    std::vector<std::string> result;
    for (const Value& entry : list.as_list())
        result.push_back(entry.as_string());
    return result;
}

SweepPage page_from(const Value& value)
{
    SweepPage page{value.at("title").as_string(), texts(value.at("axes")), {}, ""};
    for (const Value& entry : value.at("cells").as_list())
    {
        SweepCell cell{entry.at("name").as_string(),
                       texts(entry.at("values")),
                       entry.at("state").as_string(),
                       entry.at("error").as_string(),
                       entry.at("seconds").as_double(),
                       entry.at("report").as_string(),
                       {},
                       texts(entry.at("files"))};
        for (const std::string& picture : texts(entry.at("pictures")))
            cell.pictures.push_back({picture, ""});
        page.cells.push_back(std::move(cell));
    }
    return page;
}

/// A comment behind the first line: of what results the page is.
std::string marked(const std::string& html, const std::string& signature)
{
    const std::size_t end = html.find('\n') + 1;
    return html.substr(0, end) + "<!-- " + signature + " -->\n" + html.substr(end);
}

bool says_the_same(const fs::path& file, const std::string& signature)
{
    std::ifstream stream(file, std::ios::binary);
    std::string line;
    return std::getline(stream, line) && std::getline(stream, line) && line == "<!-- " + signature + " -->";
}

/// Of all but the times: a run with nothing to do took none.
std::string signature_of(const SweepSummaryRequest& request, const SweepPage& page, const Value& images)
{
    SweepPage timeless = page;
    for (SweepCell& cell : timeless.cells)
        cell.seconds = 0;
    Value::List objects;
    for (const StageOutcome& stage : request.summary->stages)
        objects.push_back(stage.object);
    return content_hash(to_json(Value::Map{
        {"version", program_version()}, {"page", to_value(timeless)}, {"objects", std::move(objects)}, {"images", images}}));
}

std::string small_copy(const ImageIo& images, const fs::path& file)
{
    const Raster8 picture = images.read_rgb(file);
    const double scale = std::min(1.0, static_cast<double>(thumbnail_px) / std::max(picture.width, picture.height));
    const auto side = [&](int px) { return std::max(1, static_cast<int>(std::lround(px * scale))); };
    return data_uri(
        "image/jpeg",
        images.encode_jpeg(scale < 1 ? resized(picture, side(picture.width), side(picture.height)) : picture, thumbnail_quality));
}

}  // namespace

std::vector<std::size_t> pictures_of(const Pipeline& pipeline, const RunSummary& summary, const CombinationOutcome& outcome,
                                     const std::string& stage, std::size_t most)
{
    const auto made_by = [&](const PipelineStage& maker)
    {
        std::vector<std::size_t> files;
        for (const std::size_t file : outcome.files)
            if (summary.files[file].stage == maker.name && is_picture(summary.files[file].path))
                files.push_back(file);
        return files;
    };
    std::vector<std::size_t> found;
    bool own = false;
    for (const std::size_t number : outcome.combination->stages)
    {
        const PipelineStage& maker = pipeline.stages[number];
        const bool alone = maker.place == outcome.combination->name;
        if ((!stage.empty() && maker.own_name != stage) || (own && !alone))
            continue;
        if (auto files = made_by(maker); !files.empty())
        {
            found = std::move(files);
            own = alone;
        }
    }
    std::vector<std::size_t> chosen;
    const std::size_t count = std::min(most, found.size());
    for (std::size_t i = 0; i < count; ++i)
        chosen.push_back(found[(2 * i + 1) * found.size() / (2 * count)]);
    return chosen;
}

SweepSummaryFiles write_sweep_summary(const SweepSummaryRequest& request)
{
    const fs::path& out = request.run->out;
    SweepSummaryFiles files{out / "sweep.json", out / page_name, ""};
    for (const Exporter::File& file : request.summary->files)
        if (file.path == files.json || file.path == files.page)
            return {{},
                    {},
                    "there is no summary of the combinations: the stage " + file.stage + " writes " +
                        file.path.filename().string() + " itself"};
    std::error_code error;
    fs::create_directories(out, error);
    if (error)
        throw Error(out.string() + ": cannot make the folder: " + error.message() + "; choose another with --out");
    write_file(files.json, to_json(sweep_as_value(*request.run->pipeline, *request.summary, *request.outcomes, out), 1) + "\n");
    const Store store(request.run->store);
    SweepPage page = page_of(request, store);
    const Value images = image_component(*request.catalog);
    const std::string signature = signature_of(request, page, images);
    if (says_the_same(files.page, signature))
        return files;
    std::string reason = "no plugin reads and writes pictures (image.opencv)";
    if (!images.is_null())
        reason = run_page_child(
            "internal-sweep",
            Value::Map{{"file", files.page.string()}, {"signature", signature}, {"page", to_value(page)}, {"images", images}},
            store);
    if (reason.empty())
        return files;
    files.note = files.page.string() + " shows the pictures themselves, not small copies: " + reason;
    page.note = "The pictures are the files beside this page, not copies in it: " + reason;
    write_file(files.page, sweep_html(page));
    return files;
}

int internal_sweep(const fs::path& request_file)
{
    return serve_page(request_file,
                      [](const Value& request)
                      {
                          const fs::path file = request.at("file").as_string();
                          SweepPage page = page_from(request.at("page"));
                          const auto images = image_codec(request.at("images"));
                          for (SweepCell& cell : page.cells)
                              for (SweepPicture& picture : cell.pictures)
                                  try
                                  {
                                      picture.uri = small_copy(*images, file.parent_path() / picture.file);
                                  }
                                  catch (const Error& error)
                                  {
                                      page.note += (page.note.empty() ? "" : "; ") + std::string(error.what());
                                  }
                          write_file(file, marked(sweep_html(page), request.at("signature").as_string()));
                      });
}

}  // namespace fresco::host

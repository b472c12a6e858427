#include "base/common.h"
#include "report/page.h"

#include "report/report.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <algorithm>
#include <map>

namespace fresco::host
{
namespace
{

constexpr int thumbnail_px = 480;

/// More combinations, fewer pictures of each: the page stays of a size that a browser opens at once.
std::size_t pictures_per_combination(std::size_t combinations)
{
    return combinations <= 24 ? 3 : combinations <= 60 ? 2 : 1;
}

class Summary
{
  public:
    Summary(const ReportRequest& request, const std::vector<CombinationOutcome>& outcomes, const std::string& pictures)
        : request_(request), outcomes_(outcomes), pictures_(pictures), run_(*request.run), pipeline_(*run_.pipeline),
          summary_(*request.summary), store_(run_.store)
    {
        for (const TypeDescription* type : request.catalog->types(Viewer::component_kind))
            std::ranges::copy(read_declaration(*type).extensions, std::back_inserter(extensions_));
        for (const PipelineStage& stage : pipeline_.stages)
            stages_.push_back(stage_data(stage, summary_.outcome_of(stage.name), store_));
        for (const CombinationOutcome& outcome : outcomes)
            combinations_.emplace_back(combination(outcome));
    }

    SweepSummaryFiles write()
    {
        Page page = sweep_page(run_);
        page.signature = signature();
        PageGuard guard(run_);
        check_replaceable(page, guard, summary_.files);
        page.data = origin_data(request_, "fresco-sweep");
        page.data.set("axes", Value::List(pipeline_.sweep.axes.begin(), pipeline_.sweep.axes.end()));
        page.data.set("combinations", combinations_);
        page.data.set("stages", stages_);
        write_data(page);
        if (is_current(page))
            return {page.json, page.html, ""};
        page.previews = previews();
        return {page.json, page.html, write_html(page, *request_.catalog, store_)};
    }

  private:
    bool is_picture(const fs::path& file) const
    {
        return std::ranges::find(extensions_, lower_extension(file)) != extensions_.end();
    }

    std::string below_out(std::size_t file) const
    {
        return summary_.files[file].path.lexically_relative(run_.out).generic_string();
    }

    Value::Map combination(const CombinationOutcome& outcome)
    {
        const Combination& own = *outcome.combination;
        Value::List stages;
        for (const std::size_t number : own.stages)
            if (const std::string& name = pipeline_.stages[number].name; summary_.outcome_of(name) != nullptr)
                stages.emplace_back(name);
        Value::List pictures;
        for (const std::size_t file :
             pictures_of(pipeline_, summary_, outcome, extensions_, pictures_, pictures_per_combination(outcomes_.size())))
        {
            pictures.emplace_back(below_out(file));
            shown_[summary_.files[file].stage].push_back(file);
        }
        const std::string report = own.name + "/report.html";
        Value::Map data = combination_data(pipeline_.sweep, summary_, outcome);
        data.insert(data.end(), {{"ran", outcome.ran_count},
                                 {"stored", outcome.stored_count},
                                 {"report", fs::exists(run_.out / report) ? report : ""},
                                 {"stages", std::move(stages)},
                                 {"pictures", std::move(pictures)},
                                 {"files", each<Value>(outcome.files, [&](std::size_t file) { return below_out(file); })}});
        return data;
    }

    /// Signature without times and the list of stages that ran, which differ in a run with nothing to do.
    std::string signature() const
    {
        Value::List combinations = combinations_;
        for (Value& combination : combinations)
            for (const char* name : {"own_seconds", "ran", "stored"})
                combination.set(name, {});
        return content_hash(to_json(Value::Map{{"version", page_version()},
                                               {"file", pipeline_.file.string()},
                                               {"combinations", std::move(combinations)},
                                               {"objects", each<Value>(summary_.stages, &StageOutcome::object)},
                                               {"viewers", viewers_of(*request_.catalog)}}));
    }

    Value previews() const
    {
        std::vector<ShownStage> shown;
        for (const PipelineStage& stage : pipeline_.stages)
            if (const auto files = shown_.find(stage.name); files != shown_.end())
            {
                ShownStage entry{&stage, summary_.outcome_of(stage.name)->object, {}};
                for (const std::size_t file : files->second)
                    entry.names.push_back(summary_.files[file]
                                              .path.lexically_relative((run_.out / stage.place).lexically_normal())
                                              .generic_string());
                shown.push_back(std::move(entry));
            }
            // The picture that its results were made after.
            else if (!stage.place.empty() &&
                     std::ranges::any_of(stage.wires, [&](const Wire& wire) { return is_picture(wire.file); }))
                shown.push_back({&stage, "", {}});
        return preview_requests(shown, *request_.catalog, store_, {run_.out, run_.out, thumbnail_px});
    }

    const ReportRequest& request_;
    const std::vector<CombinationOutcome>& outcomes_;
    const std::string& pictures_;
    const RunRequest& run_;
    const Pipeline& pipeline_;
    const RunSummary& summary_;
    Store store_;
    std::vector<std::string> extensions_;                    ///< Extensions of files that a viewer shows as pictures.
    std::map<std::string, std::vector<std::size_t>> shown_;  ///< By a stage: its pictures that stand for combinations.
    Value::List stages_;
    Value::List combinations_;
};

}  // namespace

std::vector<std::size_t> pictures_of(const Pipeline& pipeline, const RunSummary& summary, const CombinationOutcome& outcome,
                                     const std::vector<std::string>& extensions, const std::string& stage, std::size_t most)
{
    const auto is_picture = [&](const fs::path& file)
    { return std::ranges::find(extensions, file.extension().string()) != extensions.end(); };
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
    const std::size_t count = std::min(found.size(), most);
    for (std::size_t i = 0; i < count; ++i)
        chosen.push_back(found[(2 * i + 1) * found.size() / (2 * count)]);
    return chosen;
}

SweepSummaryFiles write_sweep_summary(const ReportRequest& run, const std::vector<CombinationOutcome>& outcomes,
                                      const std::string& pictures)
{
    try
    {
        return Summary(run, outcomes, pictures).write();
    }
    catch (const Error& error)
    {
        return {{}, {}, "no summary of the combinations: " + std::string(error.what())};
    }
}

}  // namespace fresco::host

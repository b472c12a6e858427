#include "base/common.h"
#include "base/machine.h"
#include "report/page.h"

#include "report/report.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <ctime>
#include <fmt/chrono.h>
#include <set>

namespace fresco::host
{
namespace
{
constexpr int data_version = 1;

std::string utc(std::time_t time)
{
    return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(time));
}

/// Subject of one report: all of a pipeline, or one combination of its matrix.
struct Subject
{
    std::vector<const PipelineStage*> stages;
    const Combination* combination = nullptr;
    fs::path out;
};

std::vector<Subject> subjects_of(const RunRequest& run)
{
    const std::vector<PipelineStage>& stages = run.pipeline->stages;
    if (run.pipeline->sweep.combinations.empty())
        return {{each(stages, [](const PipelineStage& stage) { return &stage; }), nullptr, run.out}};
    const auto subject_of = [&](const Combination& combination) -> Subject
    {
        return {each(combination.stages, [&](std::size_t number) { return &stages.at(number); }), &combination,
                run.out / combination.name};
    };
    return each(run.pipeline->sweep.combinations, subject_of);
}

Page page_of(const RunRequest& run, const Subject& subject)
{
    const std::string combination = subject.combination != nullptr ? subject.combination->name : "";
    return {.json = subject.out / "run.json",
            .html = subject.out / "report.html",
            .owner = {run.pipeline->file, combination, "", ""},
            .replace = run.replace};
}

/// Stages whose result is read by a stage that has a result.
std::set<std::string> read_stages(const ReportRequest& request, const Subject& subject)
{
    std::set<std::string> read;
    for (const PipelineStage* stage : subject.stages)
        if (const StageOutcome* outcome = request.summary->outcome_of(stage->name);
            outcome != nullptr && !outcome->object.empty())
            for (const Wire& wire : stage->wires)
                read.insert(wire.from_stage);
    return read;
}

/// Signature of a report's contents: the last results of the pipeline, which name all results above them, and failed stages.
std::string signature_of(const ReportRequest& request, const Subject& subject)
{
    const std::set<std::string> read = read_stages(request, subject);
    Value::List stages;
    for (const PipelineStage* stage : subject.stages)
    {
        const StageOutcome* outcome = request.summary->outcome_of(stage->name);
        const bool told = read.contains(stage->name);
        stages.push_back(Value::Map{{"name", stage->name},
                                    {"object", outcome != nullptr && !told ? outcome->object : ""},
                                    {"selected", outcome != nullptr},
                                    {"error", outcome != nullptr ? outcome->error : ""}});
    }
    return content_hash(to_json(Value::Map{{"version", page_version()},
                                           {"file", request.run->pipeline->file.string()},
                                           {"until", request.run->until},
                                           {"viewers", viewers_of(*request.catalog)},
                                           {"stages", std::move(stages)}}));
}

bool any_is(const ReportRequest& request, const Subject& subject, StageState state)
{
    const auto is_so = [&](const PipelineStage* stage)
    {
        const StageOutcome* outcome = request.summary->outcome_of(stage->name);
        return outcome != nullptr && outcome->state == state;
    };
    return std::ranges::any_of(subject.stages, is_so);
}

const char* outcome_text(const ReportRequest& request, const Subject& subject)
{
    if (any_is(request, subject, StageState::failed))
        return "failed";
    // A single pipeline may be interrupted although all is stored: while its files are copied.
    if ((request.interrupted && subject.combination == nullptr) || any_is(request, subject, StageState::interrupted) ||
        any_is(request, subject, StageState::blocked))
        return request.interrupted ? "interrupted" : "not finished";
    return "done";
}

Value::List problems_of(const Value::List& stages)
{
    Value::List problems;
    const auto add = [&](const char* kind, const Value& stage, const Value& text) {
        problems.push_back(Value::Map{{"kind", kind}, {"stage", stage.at("name")}, {"text", text}});
    };
    for (const Value& stage : stages)
    {
        if (!stage.at("error").as_string().empty())
            add("error", stage, stage.at("error"));
        for (const Value& message : stage.at("messages").as_list())
            if (const Value* warning = message.find("warning"))
                add("warning", stage, *warning);
    }
    return problems;
}

Value run_data(const ReportRequest& request, const Subject& subject, const Store& store)
{
    Value data = origin_data(request, "fresco-run");
    if (subject.combination != nullptr)
        *data.find("pipeline")->find("combination") = values_of(request.run->pipeline->sweep, *subject.combination);
    Value::List stages;
    std::set<std::string> names;
    for (const PipelineStage* stage : subject.stages)
    {
        names.insert(stage->name);
        stages.push_back(stage_data(*stage, request.summary->outcome_of(stage->name), store));
    }
    Value::List files;
    for (const auto& file : request.summary->files)
        if (names.contains(file.stage))
        {
            std::error_code error;
            const auto bytes = fs::file_size(file.path, error);
            files.push_back(Value::Map{{"stage", file.stage},
                                       {"name", file.path.lexically_relative(subject.out).generic_string()},
                                       {"bytes", error ? Value() : Value(static_cast<std::int64_t>(bytes))}});
        }
    data.set("outcome", outcome_text(request, subject));
    data.set("problems", problems_of(stages));
    data.set("files", std::move(files));
    data.set("stages", std::move(stages));
    return data;
}

Value previews_of(const ReportRequest& request, const Subject& subject, const Store& store)
{
    const auto shown = [&](const PipelineStage* stage) -> ShownStage
    {
        const StageOutcome* outcome = request.summary->outcome_of(stage->name);
        return {stage, outcome != nullptr ? outcome->object : "", {}};
    };
    return preview_requests(each(subject.stages, shown), *request.catalog, store, {request.run->out, subject.out});
}

ReportOutcome write_report(const ReportRequest& request, const Subject& subject, PageGuard& guard)
{
    Page page = page_of(*request.run, subject);
    try
    {
        page.signature = signature_of(request, subject);
        check_replaceable(page, guard, request.summary->files);
        if (!any_is(request, subject, StageState::done) && is_current(page))
            return {page.html, true, false, ""};
        const Store store(request.run->store);
        page.data = run_data(request, subject, store);
        page.previews = previews_of(request, subject, store);
        if (request.interrupted)
            page.hurry = "The run was interrupted: pictures come with the report of the next, which goes on from here";
        write_data(page);
        return {page.html, true, true, write_html(page, *request.catalog, store)};
    }
    catch (const std::exception& error)
    {
        return {page.html, false, false, "no report of this run: " + std::string(error.what())};
    }
}

}  // namespace

Value::Map origin_data(const ReportRequest& request, const char* format)
{
    const Pipeline& pipeline = *request.run->pipeline;
    const auto text_data = [](const PipelineText& text) { return Value::Map{{"file", text.file.string()}, {"text", text.text}}; };
    return {{"format", format},
            {"version", data_version},
            {"fresco", program_version()},
            {"processor", processor_capability().at("model")},
            {"time", utc(std::time(nullptr))},
            {"command", Value::List(request.command.begin(), request.command.end())},
            {"directory", std::filesystem::current_path().string()},
            {"out", request.run->out.string()},
            {"store", request.run->store.string()},
            {"until", request.run->until},
            {"cores", request.run->cores},
            {"seconds", request.seconds},
            {"exit_code", request.summary->exit_code},
            {"pipeline", Value::Map{{"name", pipeline.file.filename().string()},
                                    {"file", pipeline.file.string()},
                                    {"combination", Value::Map{}},
                                    {"texts", each<Value>(pipeline.texts, text_data)}}}};
}

Value stage_data(const PipelineStage& stage, const StageOutcome* outcome, const Store& store)
{
    const StageOutcome none;
    const StageOutcome& shown = outcome != nullptr ? *outcome : none;
    const Value manifest = store.whole_manifest(shown.object).value_or(Value::Map{});
    const auto entry = [&](std::string_view name, const Value& otherwise)
    {
        const Value* found = manifest.find(name);
        return found != nullptr ? *found : otherwise;
    };
    // A stored result shows what it took when it was made.
    const auto cost = [&](double measured, std::string_view stored)
    { return shown.is_of_this_run() ? measured : entry(stored, measured).as_double(); };
    const auto input_data = [](const Wire& wire)
    {
        Value::Map input{{"port", wire.port}, {"artifact", wire.artifact}};
        if (!wire.file.empty())
            input.emplace_back("file", wire.file.string());
        else
            input.insert(input.end(), {{"stage", wire.from_stage}, {"output", wire.from_port}});
        return input;
    };
    const auto output_data = [](const Value& output) {
        return Value::Map{{"name", output.at("name")}, {"artifact", output.at("artifact")}};
    };
    const Value made = entry("time_s", {});
    const std::filesystem::path log = shown.key.empty() ? "" : store.log_file(shown.key);
    return Value::Map{{"name", stage.name},
                      {"own_name", stage.own_name},
                      {"type", stage.type->type},
                      {"help", stage.type->help},
                      {"state", to_string(shown.state)},
                      {"seconds", cost(shown.seconds, "seconds")},
                      {"memory_mb", cost(shown.memory_mb, "memory_mb")},
                      {"disk_mb", entry("bytes", 0).as_double() / (1024.0 * 1024.0)},
                      {"error", shown.error},
                      {"object", shown.object},
                      {"log", std::filesystem::exists(log) ? log.string() : ""},
                      {"made", made.is_null() ? made : Value(utc(made.as_int()))},
                      {"threads", entry("threads", {})},
                      {"options", *stage.options},
                      {"inputs", each<Value>(stage.wires, input_data)},
                      {"outputs", each<Value>(stage.type->declaration.at("outputs").as_list(), output_data)},
                      {"figures", entry("report", Value::Map{})},
                      {"messages", entry("messages", Value::List{})},
                      {"curves", entry("curves", {})},
                      {"versions", entry("versions", Value::Map{})}};
}

std::vector<std::string> report_obstacles(const RunRequest& run, bool reports)
{
    std::vector<std::string> found;
    PageGuard guard(run);
    const auto add = [&](const Page& page) { std::ranges::move(page_obstacles(page, guard), std::back_inserter(found)); };
    if (reports)
        for (const Subject& subject : subjects_of(run))
            add(page_of(run, subject));
    if (!run.pipeline->sweep.axes.empty())
        add(sweep_page(run));
    return found;
}

Page sweep_page(const RunRequest& run)
{
    return {.json = run.out / "sweep.json",
            .html = run.out / "sweep.html",
            .owner = {run.pipeline->file, "", "", ""},
            .replace = run.replace};
}

std::vector<ReportOutcome> write_reports(const ReportRequest& request)
{
    PageGuard guard(*request.run);
    return each<ReportOutcome>(subjects_of(*request.run),
                               [&](const Subject& subject) { return write_report(request, subject, guard); });
}

}  // namespace fresco::host

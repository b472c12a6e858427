#include "report/page_child.h"
#include "report/report_model.h"

#include "base/machine.h"
#include "report/report.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>

#include <algorithm>
#include <ctime>
#include <fstream>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

/// What one report is about: all of a pipeline, or one combination of its matrix.
struct Subject
{
    std::vector<const PipelineStage*> stages;
    std::string title;
    fs::path out;
};

std::vector<Subject> subjects_of(const RunRequest& run)
{
    const Pipeline& pipeline = *run.pipeline;
    const std::string name = pipeline.file.filename().string();
    std::vector<Subject> subjects;
    for (const Combination& combination : pipeline.sweep.combinations)
    {
        Subject subject{{}, name + ", " + combination.name, run.out / combination.name};
        for (const std::size_t number : combination.stages)
            subject.stages.push_back(&pipeline.stages.at(number));
        subjects.push_back(std::move(subject));
    }
    if (!subjects.empty())
        return subjects;
    Subject whole{{}, name, run.out};
    for (const PipelineStage& stage : pipeline.stages)
        whole.stages.push_back(&stage);
    return {std::move(whole)};
}

Value stage_value(const PipelineStage& stage, const StageOutcome* outcome)
{
    const StageOutcome none;
    const StageOutcome& shown = outcome != nullptr ? *outcome : none;
    Value::List inputs;
    for (const Wire& wire : stage.wires)
        inputs.push_back(Value::Map{{"port", wire.port},
                                    {"artifact", wire.artifact},
                                    {"from_stage", wire.from_stage},
                                    {"from_port", wire.from_port},
                                    {"file", wire.file.string()}});
    Value::Map outputs;
    for (const auto& output : stage.type->declaration.at("outputs").as_list())
        outputs.emplace_back(output.at("name").as_string(), output.at("artifact"));
    return Value::Map{
        {"name", stage.name},          {"type", stage.type->type},
        {"help", stage.type->help},    {"state", to_string(outcome != nullptr ? outcome->state : StageState::not_selected)},
        {"seconds", shown.seconds},    {"memory_mb", shown.memory_mb},
        {"disk_mb", shown.disk_mb},    {"error", shown.error},
        {"object", shown.object},      {"options", stage.options},
        {"inputs", std::move(inputs)}, {"outputs", std::move(outputs)}};
}

bool reads(const PipelineStage& stage, const std::string& producer)
{
    return std::ranges::any_of(stage.wires, [&](const Wire& wire) { return wire.from_stage == producer; });
}

/// What a report depends on: the last results of the pipeline, which name all that is above them, and what failed.
std::string signature_of(const ReportRequest& request, const Subject& subject, const Value& images)
{
    Value::List stages;
    for (const PipelineStage* stage : subject.stages)
    {
        const StageOutcome* outcome = request.summary->outcome_of(stage->name);
        const auto tells_of_it = [&](const PipelineStage* other)
        {
            const StageOutcome* later = request.summary->outcome_of(other->name);
            return later != nullptr && !later->object.empty() && reads(*other, stage->name);
        };
        const bool told = std::ranges::any_of(subject.stages, tells_of_it);
        stages.push_back(Value::Map{{"name", stage->name},
                                    {"object", outcome != nullptr && !told ? outcome->object : ""},
                                    {"selected", outcome != nullptr},
                                    {"error", outcome != nullptr ? outcome->error : ""}});
    }
    return content_hash(to_json(Value::Map{{"version", program_version()},
                                           {"file", request.run->pipeline->file.string()},
                                           {"until", request.run->until},
                                           {"images", images},
                                           {"stages", std::move(stages)}}));
}

bool begins_with(const fs::path& file, std::string_view text)
{
    std::string begin(text.size(), '\0');
    std::ifstream stream(file, std::ios::binary);
    return stream.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == text;
}

const char* outcome_text(const ReportRequest& request, const Subject& subject)
{
    const auto any = [&](auto matches)
    {
        return std::ranges::any_of(subject.stages,
                                   [&](const PipelineStage* stage)
                                   {
                                       const StageOutcome* outcome = request.summary->outcome_of(stage->name);
                                       return outcome != nullptr && matches(outcome->state);
                                   });
    };
    if (any([](StageState state) { return state == StageState::failed; }))
        return "failed";
    // Of a single pipeline also where all is stored: its files may not have been copied to their end.
    if ((request.interrupted && request.run->pipeline->sweep.combinations.empty()) ||
        any([](StageState state) { return state == StageState::interrupted || state == StageState::blocked; }))
        return request.interrupted ? "interrupted" : "not finished";
    return "done";
}

Value request_value(const ReportRequest& request, const Subject& subject, const Value& images, const std::string& signature)
{
    const RunRequest& run = *request.run;
    Value::List stages;
    for (const PipelineStage* stage : subject.stages)
        stages.push_back(stage_value(*stage, request.summary->outcome_of(stage->name)));
    Value::List files;
    for (const auto& file : request.summary->files)
        if (std::ranges::any_of(subject.stages, [&](const PipelineStage* stage) { return stage->name == file.stage; }))
            files.push_back(
                Value::Map{{"stage", file.stage}, {"name", file.path.lexically_relative(subject.out).generic_string()}});
    return Value::Map{{"pipeline", subject.title},
                      {"store", run.store.string()},
                      {"out", subject.out.string()},
                      {"program", "fresco " + program_version()},
                      {"processor", processor_capability().at("model")},
                      {"time_s", static_cast<std::int64_t>(std::time(nullptr))},
                      {"signature", signature},
                      {"outcome", outcome_text(request, subject)},
                      {"cores", run.cores},
                      {"seconds", request.seconds},
                      {"stages", std::move(stages)},
                      {"files", std::move(files)},
                      {"images", images}};
}

/// The next run does not take it for the report of its results.
void write_without_pictures(const fs::path& file, const Value& value, const std::string& reason)
{
    ReportModel model = report_model(value);
    model.signature = "without pictures";
    ReportMedia nothing;
    nothing.notes.push_back(reason);
    write_file(file, report_page(model, nothing));
}

void write(const ReportRequest& request, const Subject& subject, ReportOutcome& outcome)
{
    const Value images = image_component(*request.catalog);
    const std::string signature = signature_of(request, subject, images);
    const bool worked = std::ranges::any_of(subject.stages,
                                            [&](const PipelineStage* stage)
                                            {
                                                const StageOutcome* of = request.summary->outcome_of(stage->name);
                                                return of != nullptr && of->state == StageState::done;
                                            });
    if (fs::is_regular_file(outcome.file) && !begins_with(outcome.file, report_begin))
        throw Error(outcome.file.string() +
                    ": not a report that fresco wrote, so it is kept; move it away, or choose another --out");
    outcome.there = true;
    if (!worked && begins_with(outcome.file, report_mark(signature)))
        return;
    const Value value = request_value(request, subject, images, signature);
    fs::create_directories(subject.out);
    if (request.interrupted)
        write_without_pictures(outcome.file, value,
                               "The run was interrupted: pictures come with the report of the next, which goes on from here");
    else if (const std::string reason = run_page_child("internal-report", value, Store(request.run->store)); !reason.empty())
    {
        outcome.note = outcome.file.string() + " is without pictures: " + reason;
        write_without_pictures(outcome.file, value, "There are no pictures: " + reason);
    }
    outcome.written = true;
}

ReportOutcome write_report(const ReportRequest& request, const Subject& subject)
{
    ReportOutcome outcome{subject.out / report_name, false, false, ""};
    for (const auto& file : request.summary->files)
        if (file.path == outcome.file)
        {
            outcome.note = "there is no report of the run: the stage " + file.stage + " writes " + report_name + " itself";
            return outcome;
        }
    try
    {
        write(request, subject, outcome);
    }
    catch (const std::exception& error)
    {
        outcome.there = outcome.written = false;
        outcome.note = "the report of the run could not be written: " + std::string(error.what());
    }
    return outcome;
}

}  // namespace

std::vector<ReportOutcome> write_reports(const ReportRequest& request)
{
    std::vector<ReportOutcome> outcomes;
    for (const Subject& subject : subjects_of(*request.run))
        outcomes.push_back(write_report(request, subject));
    return outcomes;
}

}  // namespace fresco::host

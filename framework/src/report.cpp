#include "page_child.h"
#include "report_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>
#include <fresco/host/machine.h>
#include <fresco/host/report.h>

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

const StageOutcome* outcome_of(const RunSummary& summary, const std::string& stage)
{
    const auto found = std::ranges::find(summary.stages, stage, &StageOutcome::stage);
    return found == summary.stages.end() ? nullptr : &*found;
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

/// What a report depends on: the results at the ends of the pipeline, which name all that is above them, and what failed.
std::string signature_of(const ReportRequest& request, const Subject& subject, const Value& images)
{
    Value::List stages;
    for (const PipelineStage* stage : subject.stages)
    {
        const StageOutcome* outcome = outcome_of(*request.summary, stage->name);
        const bool read = std::ranges::any_of(
            subject.stages, [&](const PipelineStage* other)
            { return std::ranges::any_of(other->wires, [&](const Wire& wire) { return wire.from_stage == stage->name; }); });
        stages.push_back(Value::Map{{"name", stage->name},
                                    {"object", outcome != nullptr && !read ? outcome->object : ""},
                                    {"selected", outcome != nullptr},
                                    {"error", outcome != nullptr ? outcome->error : ""}});
    }
    return content_hash(to_json(Value::Map{{"version", program_version()},
                                           {"file", request.run->pipeline->file.string()},
                                           {"until", request.run->until},
                                           {"images", images},
                                           {"stages", std::move(stages)}}));
}

bool says_the_same(const fs::path& file, const std::string& signature)
{
    const std::string mark = report_mark(signature);
    std::string begin(mark.size(), '\0');
    std::ifstream stream(file, std::ios::binary);
    return stream.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == mark;
}

Value request_value(const ReportRequest& request, const Subject& subject, const Value& images, const std::string& signature)
{
    const RunRequest& run = *request.run;
    Value::List stages;
    int exit_code = 0;
    for (const PipelineStage* stage : subject.stages)
    {
        const StageOutcome* outcome = outcome_of(*request.summary, stage->name);
        stages.push_back(stage_value(*stage, outcome));
        if (outcome != nullptr && (outcome->state == StageState::failed || outcome->state == StageState::blocked))
            exit_code = 1;
    }
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
                      {"exit_code", exit_code},
                      {"cores", run.cores},
                      {"seconds", request.seconds},
                      {"stages", std::move(stages)},
                      {"files", std::move(files)},
                      {"images", images}};
}

void write(const ReportRequest& request, const Subject& subject, ReportOutcome& outcome)
{
    const Value images = image_component(*request.catalog);
    const std::string signature = signature_of(request, subject, images);
    const bool worked = std::ranges::any_of(subject.stages,
                                            [&](const PipelineStage* stage)
                                            {
                                                const StageOutcome* of = outcome_of(*request.summary, stage->name);
                                                return of != nullptr && of->state == StageState::done;
                                            });
    outcome.there = true;
    if (!worked && says_the_same(outcome.file, signature))
        return;
    const Value value = request_value(request, subject, images, signature);
    fs::create_directories(subject.out);
    if (const std::string reason = run_page_child("internal-report", value, Store(request.run->store)); !reason.empty())
    {
        outcome.note = outcome.file.string() + " is without pictures: " + reason;
        ReportMedia nothing;
        nothing.notes.push_back("There are no pictures: " + reason);
        write_file(outcome.file, report_page(report_model(value), nothing));
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

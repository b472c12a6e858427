#include "report/run_data.h"

#include "base/machine.h"
#include <fresco/error.h>

#include <ctime>
#include <utility>

namespace fresco::host
{
namespace
{

constexpr int data_version = 1;

std::string utc(std::time_t time)
{
    std::tm parts{};
    char text[64] = "";
    if (gmtime_r(&time, &parts) != nullptr)
        std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text;
}

/// Empty where there is no result, or none that can be read.
Value manifest_of(const std::string& object, const Store& store)
{
    try
    {
        if (!object.empty())
            return store.manifest(object);
    }
    catch (const Error&)
    {
    }
    return Value::Map{};
}

}  // namespace

Value::Map origin_data(const ReportRequest& request, const char* format)
{
    const Pipeline& pipeline = *request.run->pipeline;
    Value::List texts;
    for (const PipelineText& text : pipeline.texts)
        texts.push_back(Value::Map{{"file", text.file.string()}, {"text", text.text}});
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
                                    {"texts", std::move(texts)}}}};
}

Value stage_data(const PipelineStage& stage, const StageOutcome* outcome, const Store& store)
{
    const StageOutcome none;
    const StageOutcome& shown = outcome != nullptr ? *outcome : none;
    const StageState state = outcome != nullptr ? outcome->state : StageState::not_selected;
    const Value manifest = manifest_of(shown.object, store);
    const auto entry = [&](std::string_view name, const Value& otherwise)
    {
        const Value* found = manifest.find(name);
        return found != nullptr ? *found : otherwise;
    };
    // Of a stored result, what it took when it was made.
    const bool now = state == StageState::done || state == StageState::failed || state == StageState::interrupted;
    const auto cost = [&](double measured, std::string_view stored)
    { return now ? measured : entry(stored, measured).as_double(); };
    Value::List inputs;
    for (const Wire& wire : stage.wires)
    {
        Value input = Value::Map{{"port", wire.port}, {"artifact", wire.artifact}};
        if (!wire.file.empty())
            input.set("file", wire.file.string());
        else
        {
            input.set("stage", wire.from_stage);
            input.set("output", wire.from_port);
        }
        inputs.push_back(std::move(input));
    }
    Value::List outputs;
    for (const Value& output : stage.type->declaration.at("outputs").as_list())
        outputs.push_back(Value::Map{{"name", output.at("name")}, {"artifact", output.at("artifact")}});
    const Value made = entry("time_s", {});
    const std::filesystem::path log = shown.key.empty() ? "" : store.log_file(shown.key);
    return Value::Map{{"name", stage.name},
                      {"own_name", stage.own_name},
                      {"type", stage.type->type},
                      {"help", stage.type->help},
                      {"state", to_string(state)},
                      {"seconds", cost(shown.seconds, "seconds")},
                      {"memory_mb", cost(shown.memory_mb, "memory_mb")},
                      {"disk_mb", entry("bytes", 0).as_double() / (1024.0 * 1024.0)},
                      {"error", shown.error},
                      {"object", shown.object},
                      {"log", std::filesystem::exists(log) ? log.string() : ""},
                      {"made", made.is_null() ? made : Value(utc(made.as_int()))},
                      {"threads", entry("threads", {})},
                      {"options", *stage.options},
                      {"inputs", std::move(inputs)},
                      {"outputs", std::move(outputs)},
                      {"figures", entry("report", Value::Map{})},
                      {"messages", entry("messages", Value::List{})},
                      {"curves", entry("curves", {})},
                      {"versions", entry("versions", Value::Map{})}};
}

}  // namespace fresco::host

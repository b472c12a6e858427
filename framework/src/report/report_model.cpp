#include "report/report_model.h"

#include <fresco/error.h>

#include <ctime>

namespace fresco::host
{
namespace
{

std::string time_text(std::int64_t seconds)
{
    const std::time_t time = seconds;
    std::tm parts{};
    char text[64] = "";
    if (gmtime_r(&time, &parts) != nullptr)
        std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts);
    return text;
}

ReportStage stage_from(const Value& value)
{
    ReportStage stage;
    stage.name = value.at("name").as_string();
    stage.type = value.at("type").as_string();
    stage.help = value.at("help").as_string();
    stage.state = value.at("state").as_string();
    stage.seconds = value.at("seconds").as_double();
    stage.memory_mb = value.at("memory_mb").as_double();
    stage.disk_mb = value.at("disk_mb").as_double();
    stage.error = value.at("error").as_string();
    stage.object = value.at("object").as_string();
    stage.options = value.at("options");
    for (const auto& input : value.at("inputs").as_list())
        stage.inputs.push_back({input.at("port").as_string(), input.at("artifact").as_string(),
                                input.at("from_stage").as_string(), input.at("from_port").as_string(),
                                input.at("file").as_string()});
    for (const auto& [name, artifact] : value.at("outputs").as_map())
        stage.outputs.push_back({name, artifact.as_string()});
    return stage;
}

void take_manifest(ReportStage& stage, const Store& store)
{
    if (stage.object.empty())
        return;
    try
    {
        const Value manifest = store.manifest(stage.object);
        const auto take = [&](std::string_view key, Value& into)
        {
            if (const Value* entry = manifest.find(key); entry != nullptr)
                into = *entry;
        };
        take("report", stage.report);
        take("messages", stage.messages);
        take("curves", stage.curves);
        if (!stage.ran())
        {
            stage.seconds = manifest.at("seconds").as_double();
            stage.memory_mb = manifest.at("memory_mb").as_double();
            stage.disk_mb = manifest.at("bytes").as_double() / (1024.0 * 1024.0);
        }
    }
    catch (const Error&)
    {
        stage.report = Value::Map{};
    }
}

}  // namespace

ReportModel report_model(const Value& request)
{
    ReportModel model;
    model.pipeline = request.at("pipeline").as_string();
    model.store = request.at("store").as_string();
    model.out = request.at("out").as_string();
    model.program = request.at("program").as_string();
    model.processor = request.at("processor").as_string();
    model.time = time_text(request.at("time_s").as_int());
    model.signature = request.at("signature").as_string();
    model.outcome = request.at("outcome").as_string();
    model.cores = static_cast<int>(request.at("cores").as_int());
    model.seconds = request.at("seconds").as_double();
    const Store store(model.store);
    for (const auto& entry : request.at("stages").as_list())
    {
        model.stages.push_back(stage_from(entry));
        take_manifest(model.stages.back(), store);
    }
    for (const auto& entry : request.at("files").as_list())
    {
        ReportFile file{entry.at("stage").as_string(), entry.at("name").as_string(), 0};
        std::error_code error;
        const auto bytes = std::filesystem::file_size(model.out / file.name, error);
        file.bytes = error ? 0 : bytes;
        model.files.push_back(std::move(file));
    }
    return model;
}

std::string report_mark(const std::string& signature)
{
    return std::string(report_begin) + signature + " -->\n";
}

}  // namespace fresco::host

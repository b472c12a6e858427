#include "store/stage_record.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>

#include <ctime>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr std::int64_t day_s = 86400;

std::optional<StageRecord> read_record(const fs::path& file)
{
    try
    {
        if (!fs::exists(file))
            return std::nullopt;
        const Value value = parse_json(read_text_file(file), file.string());
        return StageRecord{value.at("stage").as_string(), value.at("key").as_string(), value.at("object").as_string(),
                           value.at("key_document"), value.at("time_s").as_int()};
    }
    catch (const Error&)
    {
        return std::nullopt;
    }
}

}  // namespace

fs::path pipeline_folder(const Store& store, const fs::path& pipeline)
{
    return store.root() / "stages" / content_hash(fs::weakly_canonical(pipeline).string());
}

std::optional<StageRecord> read_stage_record(const Store& store, const fs::path& pipeline, const std::string& stage)
{
    return read_record(pipeline_folder(store, pipeline) / (stage + ".json"));
}

void write_stage_record(const Store& store, const fs::path& pipeline, const StageRecord& record)
{
    const fs::path folder = pipeline_folder(store, pipeline);
    const fs::path file = folder / (record.stage + ".json");
    const auto now = static_cast<std::int64_t>(std::time(nullptr));
    if (const auto old = read_record(file);
        old && old->key == record.key && old->object == record.object && now - old->time_s < day_s)
        return;
    std::error_code error;
    fs::create_directories(folder, error);
    if (!fs::exists(folder / "pipeline.path"))
        write_file(folder / "pipeline.path", fs::weakly_canonical(pipeline).string());
    write_file(file, to_json(Value::Map{{"stage", record.stage},
                                        {"key", record.key},
                                        {"object", record.object},
                                        {"time_s", now},
                                        {"key_document", record.key_document}}));
}

void remove_old_records(const Store& store, const fs::path& pipeline, const std::set<std::string>& stages)
{
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(pipeline_folder(store, pipeline), error))
        if ((entry.path().extension() == ".json" || entry.path().extension() == ".log") &&
            !stages.contains(entry.path().stem().string()))
            fs::remove(entry.path(), error);
}

std::vector<StageRecord> all_stage_records(const Store& store)
{
    std::vector<StageRecord> records;
    std::error_code error;
    for (const auto& folder : fs::directory_iterator(store.root() / "stages", error))
    {
        const fs::path origin = folder.path() / "pipeline.path";
        if (!fs::exists(origin) || !fs::exists(read_text_file(origin)))
            continue;
        for (const auto& entry : fs::directory_iterator(folder.path(), error))
            if (entry.path().extension() == ".json")
                if (auto record = read_record(entry.path()))
                    records.push_back(std::move(*record));
    }
    return records;
}

}  // namespace fresco::host

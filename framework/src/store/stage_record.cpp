#include "store/stage_record.h"
#include "base/common.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

namespace fresco::host
{
namespace
{

std::string text_of(const fs::path& pipeline)
{
    std::error_code error;
    const fs::path whole = fs::weakly_canonical(pipeline, error);
    return error ? pipeline.string() : whole.string();
}

fs::path folder_of(const Store& store, const std::string& pipeline)
{
    return store.root() / "stages" / content_hash(pipeline);
}

/// Throws Error if the record is missing, damaged, or that of another stage.
StageRecord read_record_of(const fs::path& file)
{
    const Value value = read_record(file);
    StageRecord record{value.at("stage").as_string(), value.at("key").as_string(), value.at("object").as_string(),
                       value.at("key_document"), value.at("pipeline").as_string()};
    if (record.stage != file.stem() || content_hash(record.pipeline) != file.parent_path().filename())
        throw Error(file.string() + ": is the record of another stage");
    return record;
}

/// Whether nothing is there; where that cannot be told, something may be.
bool is_gone(const fs::path& file)
{
    std::error_code error;
    return fs::status(file, error).type() == fs::file_type::not_found;
}

}  // namespace

std::optional<StageRecord> read_stage_record(const Store& store, const fs::path& pipeline, const std::string& stage)
{
    return attempt([&] { return read_record_of(pipeline_folder(store, pipeline) / (stage + ".json")); });
}

fs::path pipeline_folder(const Store& store, const fs::path& pipeline)
{
    return folder_of(store, text_of(pipeline));
}

void write_stage_record(const Store& store, const fs::path& pipeline, const StageRecord& record)
{
    if (const auto old = read_stage_record(store, pipeline, record.stage);
        old && old->key == record.key && old->object == record.object)
        return;
    const std::string text = text_of(pipeline);
    const fs::path folder = folder_of(store, text);
    make_folder(folder);
    write_record(folder / (record.stage + ".json"), Value::Map{{"pipeline", text},
                                                               {"stage", record.stage},
                                                               {"key", record.key},
                                                               {"object", record.object},
                                                               {"key_document", record.key_document}});
}

void remove_old_records(const Store& store, const fs::path& pipeline, const std::set<std::string>& stages)
{
    const fs::path folder = pipeline_folder(store, pipeline);
    if (!is_folder(folder))
        return;
    for (const fs::path& file : entries_of(folder))
        if ((file.extension() == ".json" || file.extension() == ".log") && !stages.contains(file.stem().string()))
            remove_quietly(file);
}

UsedResults used_results(const Store& store)
{
    UsedResults used;
    for (const auto& folder : entries_of(store.root() / "stages"))
    {
        bool abandoned = false;
        std::set<std::string> objects;
        std::set<std::string> damaged;
        for (const auto& file : entries_of(folder))
        {
            if (file.extension() != ".json")
                continue;
            try
            {
                const StageRecord record = read_record_of(file);
                objects.insert(record.object);
                abandoned = abandoned || is_gone(record.pipeline);
            }
            catch (const MissingInput&)
            {
                rethrow_if_there(file);
            }
            catch (const Error&)
            {
                damaged.insert(file.stem().string());
            }
        }
        if (abandoned)
        {
            used.abandoned.push_back(folder);
            continue;
        }
        used.objects.merge(objects);
        used.stages.merge(damaged);
    }
    return used;
}

}  // namespace fresco::host

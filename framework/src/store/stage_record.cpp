#include "store/stage_record.h"
#include "base/common.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <ctime>
#include <fcntl.h>
#include <limits>
#include <sys/stat.h>

namespace fresco::host
{
namespace
{

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

/// Sets the time by the file server's clock; leaves files of other users alone.
void set_time_to_now(const fs::path& file)
{
    if (const PathEntry entry(file); entry.valid())
        utimensat(entry.folder(), entry.name(), nullptr, AT_SYMLINK_NOFOLLOW);
}

/// Removes what a pipeline's folder holds of other stages than these.
void remove_records(const fs::path& folder, const std::set<std::string>& kept)
{
    for (const fs::path& file : entries_of(folder))
        if ((file.extension() == ".json" || file.extension() == ".log") && !kept.contains(file.stem().string()))
            remove_quietly(file);
}

/// Whether nothing is there; where that cannot be told, something may be.
bool is_gone(const fs::path& file)
{
    std::error_code error;
    return fs::status(file, error).type() == fs::file_type::not_found;
}

}  // namespace

fs::path resolved(const fs::path& path)
{
    std::error_code error;
    const fs::path whole = fs::weakly_canonical(path, error);
    return error ? path : whole;
}

std::optional<StageRecord> read_stage_record(const Store& store, const fs::path& pipeline, const std::string& stage)
{
    return attempt([&] { return read_record_of(pipeline_folder(store, pipeline) / (stage + ".json")); });
}

fs::path pipeline_folder(const Store& store, const fs::path& pipeline)
{
    return folder_of(store, resolved(pipeline).string());
}

void write_stage_record(const Store& store, const fs::path& pipeline, const StageRecord& record)
{
    if (const auto old = read_stage_record(store, pipeline, record.stage);
        old && old->key == record.key && old->object == record.object)
        return set_time_to_now(pipeline_folder(store, pipeline) / (record.stage + ".json"));
    const std::string text = resolved(pipeline).string();
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
    if (is_folder(folder))
        remove_records(folder, stages);
}

void remove_abandoned(const fs::path& folder)
{
    remove_records(folder, {});
    if (entries_of(folder).empty())
        remove_quietly(folder);
}

double age_days(const fs::path& path)
{
    const auto stamp = stamp_of(path);
    const double modified_s = stamp ? static_cast<double>(stamp->mtime_ns) * 1e-9 : 0;
    return std::max(0.0, static_cast<double>(std::time(nullptr)) - modified_s) / 86400.0;
}

UsedResults used_results(const Store& store, double keep_days)
{
    UsedResults used;
    for (const auto& folder : entries_of(store.root() / "stages"))
    {
        if (!is_stored_name(folder.filename().native()))
            continue;
        bool is_unseen = false;
        double days_ago = std::numeric_limits<double>::max();
        std::set<std::string> objects;
        std::set<std::string> damaged;
        for (const auto& file : entries_of(folder))
        {
            if (file.extension() != ".json")
                continue;
            try
            {
                const StageRecord record = read_record_of(file);
                is_unseen = is_unseen || is_gone(record.pipeline);
                days_ago = std::min(days_ago, age_days(file));
                objects.insert(record.object);
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
        if (is_unseen && days_ago >= keep_days)
        {
            used.abandoned.push_back(folder);
            continue;
        }
        used.stages.merge(damaged);
        (is_unseen ? used.unseen : used.objects).merge(objects);
    }
    return used;
}

}  // namespace fresco::host

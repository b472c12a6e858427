#include "store/store_tidy.h"
#include "store/stage_record.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <optional>
#include <set>
#include <thread>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

std::vector<fs::path> entries_of(const fs::path& folder)
{
    std::vector<fs::path> entries;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error))
        entries.push_back(entry.path());
    std::sort(entries.begin(), entries.end());
    return entries;
}

/// Objects that the last runs used, with all that those refer to.
std::set<std::string> used_objects(const Store& store)
{
    std::set<std::string> used;
    for (const auto& record : all_stage_records(store))
    {
        used.insert(record.object);
        try
        {
            if (store.present(record.object))
            {
                const Value manifest = store.manifest(record.object);
                for (const auto& reference : manifest.at("references").as_list())
                    used.insert(reference.as_string());
            }
        }
        catch (const Error&)
        {
            continue;  // Damaged: what it refers to cannot be told; its makers keep their own records.
        }
    }
    return used;
}

double folder_mb(const fs::path& folder)
{
    double bytes = 0;
    std::error_code error;
    for (const auto& entry : fs::recursive_directory_iterator(folder, error))
        if (entry.is_regular_file(error))
            bytes += static_cast<double>(entry.file_size(error));
    return bytes / (1024.0 * 1024.0);
}

double age_days(const fs::path& path)
{
    const auto stamp = stamp_of(path);
    const double modified_s = stamp ? static_cast<double>(stamp->mtime_ns) * 1e-9 : 0;
    return std::max(0.0, static_cast<double>(std::time(nullptr)) - modified_s) / 86400.0;
}

bool leads_to(const fs::path& key_file, const std::string& object)
{
    try
    {
        const Value results = parse_json(read_text_file(key_file, std::size_t{1} << 30U), key_file.string());
        return std::any_of(results.as_list().begin(), results.as_list().end(),
                           [&](const Value& result) { return result.at("object").as_string() == object; });
    }
    catch (const Error&)
    {
        return false;  // An unreadable record counts as none.
    }
}

/// A checkpoint serves until its stage is done, or is given up.
int remove_checkpoints(const Store& store, double keep_days, bool dry_run)
{
    int removed = 0;
    for (const auto& path : entries_of(store.root() / "checkpoints"))
    {
        if (!fs::is_directory(path))
            continue;
        const std::string key = path.filename().string();
        const auto result = store.lookup(key);
        if (!(result && store.present(*result)) && age_days(path) < keep_days)
            continue;
        ++removed;
        if (!dry_run)
            store.remove_checkpoint(key);
    }
    return removed;
}

/// A log goes with the result of its key. That of a stage that has none, because it failed, is kept as long as a checkpoint.
void remove_logs(const Store& store, const std::set<std::string>& kept_keys, const std::set<std::string>& removed_keys,
                 double keep_days)
{
    for (const auto& path : entries_of(store.root() / "logs"))
    {
        const std::string key = path.stem().string();
        if (!kept_keys.contains(key) && (removed_keys.contains(key) || age_days(path) >= keep_days))
            remove_quietly(path);
    }
}

/// The key that led to an object: by its manifest, or, where that is what is damaged, by the keys' own files. Nothing if no key
/// leads to it.
std::optional<std::string> key_of_object(const Store& store, const std::string& object)
{
    try
    {
        return store.manifest(object).at("key").as_string();
    }
    catch (const Error&)
    {
        for (const auto& file : entries_of(store.root() / "keys"))
            if (leads_to(file, object))
                return file.stem().string();
        return std::nullopt;
    }
}

}  // namespace

std::vector<StoredObject> list_objects(const Store& store)
{
    const std::set<std::string> used = used_objects(store);
    std::vector<StoredObject> objects;
    for (const auto& path : entries_of(store.root() / "objects"))
    {
        StoredObject object;
        object.id = path.filename().string();
        object.in_use = used.contains(object.id);
        try
        {
            const Value manifest = store.manifest(object.id);
            object.stage = manifest.at("stage").as_string();
            object.type = manifest.at("type").as_string();
            object.key = manifest.at("key").as_string();
            object.time_s = manifest.at("time_s").as_int();
            object.disk_mb = static_cast<double>(manifest.at("bytes").as_int()) / (1024.0 * 1024.0);
        }
        catch (const Error&)
        {
            object.whole = false;
            object.disk_mb = folder_mb(path);
        }
        objects.push_back(std::move(object));
    }
    std::stable_sort(objects.begin(), objects.end(), [](const auto& a, const auto& b) { return a.time_s > b.time_s; });
    return objects;
}

std::vector<Damage> verify_store(const Store& store, int threads)
{
    std::vector<Damage> damages;
    for (const auto& path : entries_of(store.root() / "objects"))
    {
        const std::string id = path.filename().string();
        if (store.present(id))
            if (auto damage = store.verify(id, threads))
                damages.push_back(std::move(*damage));
    }
    return damages;
}

bool discard_damaged(const Store& store, const std::string& object, int threads)
{
    constexpr int patience = 500;  // times 20 ms
    FileLock lock;
    if (const auto key = key_of_object(store, object))
    {
        lock = FileLock(store.lock_file(*key));
        for (int tries = 0; !lock.try_exclusive(); ++tries)
        {
            if (!store.present(object))
                return true;
            if (tries == patience)
                throw Error(store.object(object).string() +
                            ": is damaged, and another run is at work on the same result; run again when that one has ended");
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }
    if (store.present(object) && !store.verify(object, threads))
        return false;
    store.discard(object);
    return true;
}

TidyResult tidy_store(const Store& store, double keep_days, bool dry_run)
{
    FileLock lock = store_lock(store);
    if (!lock.try_exclusive())
        throw Error(store.root().string() + ": a run is using the store; tidy up when it has ended");
    TidyResult result;
    const double now = static_cast<double>(std::time(nullptr));
    std::set<std::string> kept_keys;
    std::set<std::string> removed_keys;
    for (auto& object : list_objects(store))
    {
        const bool old = (now - static_cast<double>(object.time_s)) / 86400.0 >= keep_days;
        if (object.whole && (object.in_use || !old))
        {
            kept_keys.insert(object.key);
            continue;
        }
        removed_keys.insert(object.key);
        result.freed_mb += object.disk_mb;
        if (!dry_run)
            store.discard(object.id);
        result.removed.push_back(std::move(object));
    }
    result.checkpoints = remove_checkpoints(store, keep_days, dry_run);
    if (!dry_run)
        remove_logs(store, kept_keys, removed_keys, keep_days);
    for (const auto& path : entries_of(store.root() / "tmp"))
    {
        ++result.leftovers;
        if (!dry_run)
            remove_quietly(path);
    }
    return result;
}

}  // namespace fresco::host

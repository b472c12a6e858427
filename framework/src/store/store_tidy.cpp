#include "store/store_tidy.h"
#include "base/common.h"
#include "store/stage_record.h"
#include "store/statistics.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <optional>
#include <set>

namespace fresco::host
{
namespace
{

/// Uses the manifest. False where it is gone or damaged; throws what hinders from reading one that is there.
template <class Use>
bool with_manifest(const Store& store, const std::string& object, const Use& use)
{
    try
    {
        use(store.manifest(object));
        return true;
    }
    catch (const Error& error)
    {
        if (dynamic_cast<const MissingInput*>(&error) != nullptr)
            rethrow_if_there(store.manifest_file(object));
        return false;
    }
}

/// With what the used objects refer to. Of damaged ones that cannot be told; its makers have their own records.
UsedResults all_used(const Store& store, double keep_days)
{
    const auto add_references = [&](std::set<std::string>& objects)
    {
        for (const std::string& object : std::set<std::string>(objects))
            with_manifest(store, object,
                          [&](const Value& manifest)
                          {
                              for (const auto& reference : manifest.at("references").as_list())
                                  objects.insert(reference.as_string());
                          });
    };
    UsedResults used = used_results(store, keep_days);
    add_references(used.objects);
    add_references(used.unseen);
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

/// A checkpoint serves until its stage is done, or is given up.
int remove_checkpoints(const Store& store, double keep_days, bool dry_run)
{
    int removed = 0;
    for (const auto& path : entries_of(store.root() / "checkpoints"))
    {
        const std::string key = path.filename().string();
        if (!is_stored_name(key))
            continue;
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
        if (is_stored_name(key) && path.extension() == ".log" && !kept_keys.contains(key) &&
            (removed_keys.contains(key) || age_days(path) >= keep_days))
            remove_quietly(path);
    }
}

/// The key that led to an object, by the names of the keys' files: its manifest may be what is damaged. Nothing if no key does.
std::optional<std::string> key_of_object(const Store& store, const std::string& object)
{
    for (const auto& file : entries_of(store.root() / "keys"))
        if (object.starts_with(object_prefix(file.stem().string())))
            return file.stem();
    return std::nullopt;
}

/// Removes what the removed results leave behind: records of keys that lead to no result, locks that nobody holds, and
/// what killed writers left. A result that is used but not there keeps its record: what was made from it is found by that.
void remove_leftovers(const Store& store, const UsedResults& used)
{
    std::set<std::string> objects = used.objects;
    objects.insert(used.unseen.begin(), used.unseen.end());
    for (const auto& path : stored_objects(store))
        objects.insert(path.filename().string());
    for (const auto& file : entries_of(store.root() / "keys"))
    {
        const std::string prefix = object_prefix(file.stem().string());
        const auto object = objects.lower_bound(prefix);
        const bool leads_on = object != objects.end() && object->starts_with(prefix);
        if (is_stored_name(file.stem().native()) && file.extension() == ".json" && !leads_on)
            remove_quietly(file);
    }
    for (const auto& file : entries_of(store.root() / "locks"))
        if (is_stored_name(file.filename().native()) && FileLock(file).try_exclusive())
            remove_quietly(file);
    std::vector<fs::path> folders = entries_of(store.root() / "stages");
    std::erase_if(folders, [](const fs::path& folder) { return !is_stored_name(folder.filename().native()); });
    folders.insert(folders.end(), {store.root(), store.root() / "keys", store.root() / "checkpoints"});
    for (const auto& folder : folders)
        for (const auto& file : entries_of(folder))
            if (is_temporary_name(file.filename().native()))
                remove_quietly(file);
}

std::vector<StoredObject> objects_of(const Store& store, const UsedResults& used)
{
    std::vector<StoredObject> objects;
    for (const auto& path : stored_objects(store))
    {
        StoredObject object;
        object.id = path.filename().string();
        const auto describe = [&](const Value& manifest)
        {
            object.stage = manifest.at("stage").as_string();
            object.type = manifest.at("type").as_string();
            object.key = manifest.at("key").as_string();
            object.time_s = manifest.at("time_s").as_int();
            object.disk_mb = static_cast<double>(manifest.at("bytes").as_int()) / (1024.0 * 1024.0);
        };
        object.whole = with_manifest(store, object.id, describe);
        if (!object.whole)
            object.disk_mb = folder_mb(path);
        object.in_use = used.objects.contains(object.id) || used.stages.contains(object.stage);
        objects.push_back(std::move(object));
    }
    std::ranges::stable_sort(objects, std::greater(), &StoredObject::time_s);
    return objects;
}

}  // namespace

std::vector<StoredObject> list_objects(const Store& store)
{
    // There may be records of another user that may not be read here. Nothing is removed by this list.
    return objects_of(store, attempt([&] { return all_used(store, 0); }).value_or(UsedResults{}));
}

std::vector<Damage> verify_store(const Store& store, int threads)
{
    std::vector<Damage> damages;
    for (const auto& path : stored_objects(store))
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
    FileLock lock;
    if (const auto key = key_of_object(store, object))
    {
        lock = FileLock(store.lock_file(*key));
        if (!lock.try_exclusive_for(std::chrono::seconds(10)))
        {
            if (!store.present(object))
                return true;
            const std::string holder = FileLock::holder_of(store.lock_file(*key));
            throw Error(store.object(object).string() + ": is damaged, and another run" +
                        (holder.empty() ? "" : " (" + holder + ")") +
                        " is at work on the same result; run again when that one has ended");
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
    lock.sign();
    TidyResult result;
    const double now = static_cast<double>(std::time(nullptr));
    std::set<std::string> kept_keys;
    std::set<std::string> removed_keys;
    const UsedResults used = all_used(store, keep_days);
    for (auto& object : objects_of(store, used))
    {
        const bool old = (now - static_cast<double>(object.time_s)) / 86400.0 >= keep_days;
        if (object.whole && (object.in_use || !old || used.unseen.contains(object.id)))
        {
            const bool only_unseen = !object.in_use && old;
            result.kept += only_unseen ? 1 : 0;
            result.kept_mb += only_unseen ? object.disk_mb : 0;
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
    for (const auto& path : abandoned_temporaries(store))
    {
        if (dry_run || remove_path(path))
            ++result.leftovers;
        else
            result.stuck.push_back(path.string() + ": " + std::strerror(errno));
    }
    if (dry_run)
        return result;
    for (const auto& folder : used.abandoned)
        remove_abandoned(folder);
    remove_leftovers(store, used);
    // Both are caches: where there is still no room, they stay as they are.
    attempt([&] { FileHashes(store.file_index()).tidy(); });
    attempt([&] { Statistics(store).tidy(); });
    return result;
}

}  // namespace fresco::host

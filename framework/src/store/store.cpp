#include "store/store.h"
#include "base/common.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/parallel.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>
#include <random>
#include <sys/stat.h>

namespace fresco::host
{

namespace
{

constexpr const char* another_store = "choose another store with --store";
constexpr const char* store_folders[] = {"objects", "keys", "stages", "checkpoints", "logs", "locks", "tmp"};
constexpr std::string_view store_format = "fresco store 2\n";

std::string gpu_text(const Value& gpus)
{
    const std::vector<std::string> models = each(gpus.as_list(), &Value::as_string);
    return models.empty() ? "none" : join(models);
}

/// A process that was killed while it made the store left at most the draft of its format.
bool is_empty_but_for_drafts(const fs::path& root)
{
    return std::ranges::all_of(entries_of(root),
                               [](const fs::path& path) { return is_temporary_name(path.filename().native()); });
}

void check_format(const fs::path& root)
{
    const fs::path file = root / "format";
    const bool has_all = std::ranges::all_of(store_folders, [&](const char* folder) { return is_folder(root / folder); });
    // Another process may have made the store meanwhile: look for its format last.
    if (!has_all && !is_empty_but_for_drafts(root) && !path_status(file))
        throw Error(root.string() + ": is neither empty nor a store: choose another folder with --store");
    const auto found = attempt([&] { return read_checked_text(file); });
    if (!found && !has_all && path_status(file))
        throw Error(file.string() + ": is not the file of a store: choose another folder with --store");
    if (found && *found != store_format)
        throw Error(file.string() + ": the store is \"" + found->substr(0, found->find('\n')) + "\", this program needs \"" +
                    std::string(store_format.substr(0, store_format.size() - 1)) + "\": remove " + root.string() +
                    " to compute its results again, or choose another with --store");
    // It is damaged, or lost: a disk that is purged of old files loses it first. All else in the store is checked by itself.
    if (!found)
        write_checked(file, store_format);
}

constexpr std::size_t results_per_key = 8;

Value result_entry(const StoredResult& result)
{
    Value::List dependencies = each<Value>(result.dependencies, [&](const auto& dependency) { return to_value(dependency); });
    return Value::Map{{"object", result.object},
                      {"references", Value::List(result.references.begin(), result.references.end())},
                      {"dependencies", std::move(dependencies)}};
}

/// The results in the record of a key. Throws Error if the record is missing or damaged.
std::vector<StoredResult> read_results(const Store& store, const std::string& key)
{
    const fs::path file = store.key_file(key);
    const Value record = read_record(file);
    if (record.at("key").as_string() != key)
        throw Error(file.string() + ": is the record of another key");
    std::vector<StoredResult> results;
    for (const auto& entry : record.at("results").as_list())
    {
        results.push_back(result_of(entry.at("object").as_string(), entry));
        if (!results.back().object.starts_with(object_prefix(key)))
            throw Error(file.string() + ": leads to the result of another key");
    }
    return results;
}

void write_results(const Store& store, const std::string& key, const std::vector<StoredResult>& results)
{
    write_record(store.key_file(key), Value::Map{{"key", key}, {"results", each<Value>(results, result_entry)}});
}

/// Writes the stamps of the result's dependencies into the record of its key, unless another process is at work on the key.
void renew_stamps(const Store& store, const std::string& key, const StoredResult& result)
{
    FileLock lock(store.lock_file(key));
    if (!lock.try_exclusive())
        return;
    std::vector<StoredResult> results = read_results(store, key);
    if (const auto same = std::ranges::find(results, result.object, &StoredResult::object); same != results.end())
        same->dependencies = result.dependencies;
    write_results(store, key, results);
}

/// Why a result does not serve a stage with these input files now; empty: it does. `renewed`: a stamp of its dependencies was.
std::string misfit_of(StoredResult& result, const std::vector<fs::path>& files, bool& renewed)
{
    const auto is_listed = [&](const fs::path& file)
    { return std::ranges::find(result.dependencies, file, &Dependency::path) != result.dependencies.end(); };
    if (!result.dependencies.empty() && !std::ranges::all_of(files, is_listed))
        return (files.empty() ? "an input" : files.front().string()) + " has another path, and the stage reads more than it";
    for (Dependency& dependency : result.dependencies)
    {
        const Change change = compare(dependency);
        if (change == Change::contents)
            return dependency.path.string() + (dependency.folder ? ": other files in the folder" : " changed");
        renewed = renewed || change == Change::stamp;
    }
    return "";
}

}  // namespace

bool Store::is_at(const fs::path& folder)
{
    return path_status(folder / "format").has_value();
}

Store::Store(fs::path root) : root_(std::move(root))
{
    make_folder_or(root_, another_store);
    forbid_links_below(fs::absolute(root_), std::string("remove it, or ") + another_store);
    check_format(root_);
    for (const char* folder : store_folders)
        make_folder(root_ / folder);
}

WorkFolder::~WorkFolder()
{
    remove_quietly(path_);
}

fs::path Store::make_temporary(const std::string& prefix) const
{
    for (std::random_device random;;)
    {
        const std::string name = fmt::format("{:08x}{:08x}", random(), random());
        const fs::path folder = root_ / "tmp" / (prefix.empty() ? name : prefix + "." + name);
        const PathEntry entry(folder);
        // Closed to others until it is published: another user could swap a file for a link while a plugin writes it.
        if (entry.valid() && mkdirat(entry.folder(), entry.name(), 0700) == 0)
            return folder;
        if (!entry.valid() || errno != EEXIST)
            throw Error((root_ / "tmp").string() + ": cannot make a folder: " + std::strerror(errno));
    }
}

void Store::remove_temporaries(const std::string& prefix) const
{
    // Otherwise the next run removes them.
    for (const fs::path& path : attempt([&] { return entries_of(root_ / "tmp"); }).value_or(std::vector<fs::path>{}))
        if (path.filename().string().starts_with(prefix))
            remove_quietly(path);
}

bool Store::present(std::string_view object) const
{
    const fs::path file = manifest_file(object);
    if (is_file(file))
        return true;
    // A result that cannot be looked at for a moment is not gone.
    if (errno == EMFILE || errno == ENFILE || errno == EIO || errno == ENOMEM)
        throw Error(file.string() + ": cannot be read: " + std::strerror(errno));
    return false;
}

bool Store::present(const StoredResult& result) const
{
    return present(result.object) && std::ranges::all_of(result.references, [&](const auto& id) { return present(id); });
}

fs::path Store::checkpoint_file(std::string_view key, std::string_view extension) const
{
    return root_ / "checkpoints" / (std::string(key) + std::string(extension));
}

std::string Store::checkpoint_refusal(std::string_view key, const Value& place) const
{
    const fs::path file = checkpoint_file(key, ".dependencies");
    if (!path_status(file))
        return "";
    const Value made = read_record(file).at("place");
    if (!(made.at("features") == place.at("features")))
        return "its checkpoint was made on another type of processor (" + made.at("features").as_string() + "; here " +
               place.at("features").as_string() + ")";
    if (!(made.at("gpus") == place.at("gpus")))
        return "its checkpoint was made with other GPUs (" + gpu_text(made.at("gpus")) + "; here " + gpu_text(place.at("gpus")) +
               ")";
    return "";
}

double Store::checkpoint_share(std::string_view key) const
{
    const auto share = attempt([&] { return read_text_file(checkpoint_file(key, ".share"), 100); });
    return share ? std::clamp(std::strtod(share->c_str(), nullptr), 0.0, 0.99) : 0;
}

void Store::remove_checkpoint(std::string_view key) const
{
    for (const char* extension : {"", ".dependencies", ".curves", ".share"})
        remove_quietly(checkpoint_file(key, extension));
}

void Store::drop_checkpoint(std::string_view key) const
{
    if (!remove_path(checkpoint(key)))
        throw Error(checkpoint(key).string() + ": is outdated and cannot be removed: " + std::strerror(errno));
    remove_checkpoint(key);
    sync_folder(root_ / "checkpoints");
}

std::string object_id(const std::string& key, const std::vector<Dependency>& dependencies)
{
    std::vector<std::string> parts;
    for (const auto& dependency : dependencies)
        parts.push_back(dependency.path.string() + '\0' + dependency.hash);
    std::sort(parts.begin(), parts.end());
    std::string joined = key;
    for (const auto& part : parts)
        joined += '\0' + part;
    const std::string prefix = object_prefix(key);
    return prefix + content_hash(joined).substr(prefix.size());
}

std::string object_prefix(std::string_view key)
{
    constexpr std::size_t half = 16;
    return content_hash(key).substr(0, half);
}

Value Store::manifest(std::string_view object) const
{
    const fs::path file = manifest_file(object);
    Value manifest = read_record(file);
    if (object_id(manifest.at("key").as_string(), each(manifest.at("dependencies").as_list(), dependency_from)) != object)
        throw Error(file.string() + ": is the manifest of another result");
    return manifest;
}

std::optional<Value> Store::whole_manifest(std::string_view object) const
{
    return attempt([&] { return manifest(object); });
}

std::optional<Damage> Store::verify(const std::string& object, int threads, const std::string& below) const
{
    std::vector<StoredFile> files;
    try
    {
        const Value found = manifest(object);
        for (const auto& entry : found.at("files").as_list())
            if (StoredFile file = stored_file_from(entry);
                below.empty() || file.path == below || file.path.starts_with(below + "/"))
                files.push_back(std::move(file));
    }
    catch (const Error& error)
    {
        return Damage{object, error.what()};
    }
    const fs::path folder = this->object(object);
    // An output that its stage left out has neither.
    if (!below.empty() && files.empty() && path_status(folder / below))
        return Damage{object, (folder / below).string() + ": is not among the files of the result"};
    std::vector<std::optional<std::string>> damage(files.size());
    parallel_for(files.size(), 1, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                         damage[i] = find_damage(folder, files[i]);
                 });
    for (const auto& text : damage)
        if (text)
            return Damage{object, *text};
    return std::nullopt;
}

void Store::discard(std::string_view object) const
{
    if (present(object))
    {
        if (!remove_path(manifest_file(object)))
            throw Error(manifest_file(object).string() + ": cannot be removed: " + std::strerror(errno));
        sync_folder(this->object(object));
    }
    // A full disk has no room to move it aside; remove it in place: without a manifest it is garbage.
    if (const auto aside = attempt([&] { return make_temporary(); }))
    {
        rename_path(this->object(object), *aside / "object");
        remove_quietly(*aside);
    }
    else
        remove_quietly(this->object(object));
}

std::vector<fs::path> stored_objects(const Store& store)
{
    std::vector<fs::path> objects = entries_of(store.root() / "objects");
    std::erase_if(objects, [](const fs::path& path) { return !is_stored_name(path.filename().native()); });
    return objects;
}

void make_folder_or(const fs::path& folder, const std::string& advice)
{
    try
    {
        make_folder(folder);
    }
    catch (const Error& error)
    {
        throw Error(std::string(error.what()) + "; " + advice);
    }
}

void remove_quietly(const fs::path& path)
{
    attempt([&] { remove_path(path); });
}

bool is_stored_name(std::string_view name)
{
    constexpr std::size_t digits = 32;
    return name.size() == digits && name.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

bool is_temporary_name(std::string_view name)
{
    return name.starts_with(temporary_file_prefix) && is_stored_name(name.substr(temporary_file_prefix.size()));
}

void rethrow_if_there(const fs::path& file)
{
    if (path_status(file))
        throw;
}

FileLock store_lock(const Store& store)
{
    return FileLock(store.lock_file("store"));
}

bool enter_store(const Store& store, FileLock& lock)
{
    if (lock.try_exclusive())
        for (const fs::path& path : abandoned_temporaries(store))
            remove_quietly(path);
    return lock.try_shared();
}

std::vector<fs::path> abandoned_temporaries(const Store& store)
{
    constexpr std::size_t shortest = 16;
    std::vector<fs::path> folders = entries_of(store.root() / "tmp");
    std::erase_if(folders,
                  [](const fs::path& path)
                  {
                      const std::string name = path.filename();
                      return name.size() < shortest || name.find_first_not_of("0123456789abcdef.") != std::string::npos;
                  });
    return folders;
}

StoredResult result_of(const std::string& object, const Value& value)
{
    return {object, each(value.at("references").as_list(), &Value::as_string),
            each(value.at("dependencies").as_list(), dependency_from)};
}

std::optional<StoredResult> Store::lookup(const std::string& key, std::string* why_not, const std::vector<fs::path>& files) const
{
    // A record that cannot be used counts as empty: the stage runs again.
    for (StoredResult& result : attempt([&] { return read_results(*this, key); }).value_or(std::vector<StoredResult>{}))
    {
        bool renewed = false;
        if (const std::string misfit = misfit_of(result, files, renewed); !misfit.empty())
        {
            if (why_not != nullptr && why_not->empty())
                *why_not = misfit;
            continue;
        }
        // If the new stamps cannot be written, the next lookup reads the files once more.
        if (renewed)
            attempt([&] { renew_stamps(*this, key, result); });
        return std::move(result);
    }
    return std::nullopt;
}

void Store::look_again() const
{
    for (const char* folder : {"keys", "objects"})
    {
        std::error_code error;
        const fs::directory_iterator listed(root_ / folder, error);
    }
}

void Store::remember(const std::string& key, const StoredResult& result) const
{
    std::vector<StoredResult> results = attempt([&] { return read_results(*this, key); }).value_or(std::vector<StoredResult>{});
    std::erase_if(results, [&](const StoredResult& other) { return other.object == result.object; });
    results.insert(results.begin(), result);
    if (results.size() > results_per_key)
        results.resize(results_per_key);
    write_results(*this, key, results);
}

}  // namespace fresco::host

#include "store/store.h"
#include "base/durable_file.h"
#include <fresco/checked_file.h>
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <random>
#include <sys/stat.h>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr std::string_view store_format = "fresco store 2\n";
/// The first format's file had no checksum.
constexpr std::string_view first_format = "fresco store 1\n";
constexpr std::size_t results_per_key = 8;

std::vector<std::string> text_list(const Value& value)
{
    std::vector<std::string> texts;
    for (const auto& entry : value.as_list())
        texts.push_back(entry.as_string());
    return texts;
}

Value to_value(const StoredResult& result)
{
    Value::List dependencies;
    for (const auto& dependency : result.dependencies)
        dependencies.push_back(to_value(dependency));
    return Value::Map{{"object", result.object},
                      {"references", Value::List(result.references.begin(), result.references.end())},
                      {"dependencies", std::move(dependencies)}};
}

/// By the record of a key, or by the object's manifest.
StoredResult result_from(const std::string& object, const Value& value)
{
    StoredResult result{object, text_list(value.at("references")), {}};
    for (const auto& dependency : value.at("dependencies").as_list())
        result.dependencies.push_back(dependency_from(dependency));
    return result;
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
        results.push_back(result_from(entry.at("object").as_string(), entry));
        if (!results.back().object.starts_with(object_prefix(key)))
            throw Error(file.string() + ": leads to the result of another key");
    }
    return results;
}

/// The same; a record that cannot be used counts as empty: the stage runs again.
std::vector<StoredResult> results_of(const Store& store, const std::string& key)
{
    try
    {
        return read_results(store, key);
    }
    catch (const Error&)
    {
        return {};
    }
}

void write_results(const Store& store, const std::string& key, const std::vector<StoredResult>& results)
{
    Value::List entries;
    for (const auto& result : results)
        entries.push_back(to_value(result));
    write_record(store.key_file(key), Value::Map{{"key", key}, {"results", std::move(entries)}});
}

/// Writes what `changed` makes of the record of a key. False where another process is at work on the key, or the disk is full.
bool change_results(const Store& store, const std::string& key, const std::function<std::vector<StoredResult>()>& changed)
{
    try
    {
        FileLock lock(store.lock_file(key));
        if (!lock.try_exclusive())
            return false;
        write_results(store, key, changed());
        return true;
    }
    catch (const Error&)
    {
        return false;
    }
}

bool contains_all(const std::vector<Dependency>& dependencies, const std::vector<fs::path>& files)
{
    return std::all_of(files.begin(), files.end(),
                       [&](const fs::path& file)
                       {
                           return std::any_of(dependencies.begin(), dependencies.end(),
                                              [&](const Dependency& dependency) { return dependency.path == file; });
                       });
}

[[noreturn]] void refuse_format(const fs::path& file, const std::string& found)
{
    throw Error(file.string() + ": the store is \"" + found.substr(0, found.find('\n')) + "\", this program needs \"" +
                std::string(store_format.substr(0, store_format.size() - 1)) + "\": remove " + file.parent_path().string() +
                " to compute its results again, or choose another with --store");
}

void check_format(const fs::path& root)
{
    const fs::path file = root / "format";
    if (!stamp_of(file))
        return write_checked(file, store_format);
    const std::string text = read_text_file(file);
    if (text == first_format)
        refuse_format(file, text);
    std::string found;
    try
    {
        found = read_checked_text(file);
    }
    catch (const Error&)
    {
        if (!stamp_of(root / "objects") || !stamp_of(root / "keys"))
            throw Error(file.string() + ": is not the file of a store: choose another folder with --store");
        // Damaged. All else in the store is checked by itself.
        return write_checked(file, store_format);
    }
    if (found != store_format)
        refuse_format(file, found);
}

}  // namespace

bool Store::is_at(const fs::path& folder)
{
    return stamp_of(folder / "format").has_value();
}

Store::Store(fs::path root) : root_(std::move(root))
{
    try
    {
        make_folder(root_);
    }
    catch (const Error& error)
    {
        throw Error(std::string(error.what()) + "; choose another store with --store");
    }
    check_format(root_);
    for (const char* folder : {"objects", "keys", "stages", "checkpoints", "logs", "locks", "tmp"})
        make_folder(root_ / folder);
}

fs::path Store::make_temporary(const std::string& prefix) const
{
    for (std::random_device random;;)
    {
        const fs::path folder = root_ / "tmp" / fmt::format("{}.{:08x}{:08x}", prefix, random(), random());
        if (mkdir(folder.c_str(), 0777) == 0)
            return folder;
        if (errno != EEXIST)
            throw Error((root_ / "tmp").string() + ": cannot make a folder: " + std::strerror(errno));
    }
}

void Store::remove_temporaries(const std::string& prefix) const
{
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(root_ / "tmp", error))
        if (entry.path().filename().string().starts_with(prefix))
            remove_quietly(entry.path());
}

std::optional<StoredResult> Store::lookup(const std::string& key, std::string* why_not, const std::vector<fs::path>& files) const
{
    std::vector<StoredResult> results = results_of(*this, key);
    for (std::size_t i = 0; i < results.size(); ++i)
    {
        bool renewed = false;
        bool fits = results[i].dependencies.empty() || contains_all(results[i].dependencies, files);
        if (!fits && why_not != nullptr && why_not->empty())
            *why_not = files.front().string() + " has another path, and the stage reads more than it";
        if (!fits)
            continue;
        for (auto& dependency : results[i].dependencies)
        {
            const Change change = compare(dependency);
            renewed = renewed || change == Change::stamp;
            fits = change != Change::contents;
            if (!fits)
            {
                if (why_not != nullptr && why_not->empty())
                    *why_not = dependency.path.string() + (dependency.folder ? ": other files in the folder" : " changed");
                break;
            }
        }
        if (!fits)
            continue;
        // Where the new stamps cannot be written, the next look-up reads the files once more.
        if (renewed)
            change_results(*this, key,
                           [&]
                           {
                               std::vector<StoredResult> now = read_results(*this, key);
                               for (auto& other : now)
                                   if (other.object == results[i].object)
                                       other.dependencies = results[i].dependencies;
                               return now;
                           });
        return results[i];
    }
    return std::nullopt;
}

bool Store::restore(const std::string& key) const
{
    try
    {
        read_results(*this, key);
        return false;
    }
    catch (const Error&)
    {
        if (!objects_)
        {
            objects_.emplace();
            std::error_code error;
            for (const auto& entry : fs::directory_iterator(root_ / "objects", error))
                objects_->insert(entry.path().filename().string());
        }
    }
    std::vector<StoredResult> results;
    const std::string prefix = object_prefix(key);
    for (auto object = objects_->lower_bound(prefix); object != objects_->end() && object->starts_with(prefix); ++object)
    {
        try
        {
            const Value found = manifest(*object);
            if (results.size() < results_per_key && found.at("key").as_string() == key)
                results.push_back(result_from(*object, found));
        }
        catch (const Error&)
        {
            continue;  // Nothing was published there, or it is damaged.
        }
    }
    return !results.empty() && change_results(*this, key, [&] { return results; });
}

void Store::remember(const std::string& key, const StoredResult& result) const
{
    std::vector<StoredResult> results = results_of(*this, key);
    std::erase_if(results, [&](const StoredResult& other) { return other.object == result.object; });
    results.insert(results.begin(), result);
    if (results.size() > results_per_key)
        results.resize(results_per_key);
    write_results(*this, key, results);
}

bool Store::present(std::string_view object) const
{
    return stamp_of(manifest_file(object)).has_value();
}

bool Store::present(const StoredResult& result) const
{
    return present(result.object) &&
           std::all_of(result.references.begin(), result.references.end(), [&](const auto& id) { return present(id); });
}

fs::path Store::checkpoint_file(std::string_view key, std::string_view extension) const
{
    return root_ / "checkpoints" / (std::string(key) + std::string(extension));
}

double Store::checkpoint_share(std::string_view key) const
{
    double share = 0;
    std::ifstream(checkpoint_file(key, ".share")) >> share;
    // An estimate of no time at all would count as unknown.
    return std::clamp(share, 0.0, 0.99);
}

void Store::remove_checkpoint(std::string_view key) const
{
    for (const char* extension : {"", ".dependencies", ".curves", ".share"})
        remove_quietly(checkpoint_file(key, extension));
}

void Store::drop_checkpoint(std::string_view key) const
{
    std::error_code error;
    fs::remove_all(checkpoint(key), error);
    if (error)
        throw Error(checkpoint(key).string() + ": is outdated and cannot be removed: " + error.message());
    remove_checkpoint(key);
    sync_path(root_ / "checkpoints");
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
    std::vector<Dependency> dependencies;
    for (const auto& dependency : manifest.at("dependencies").as_list())
        dependencies.push_back(dependency_from(dependency));
    if (object_id(manifest.at("key").as_string(), dependencies) != object)
        throw Error(file.string() + ": is the manifest of another result");
    return manifest;
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
    if (!below.empty() && files.empty() && stamp_of(folder / below))
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
    std::error_code error;
    if (present(object))
    {
        fs::remove(manifest_file(object), error);
        if (error)
            throw Error(manifest_file(object).string() + ": cannot be removed: " + error.message());
        sync_path(this->object(object));
    }
    const fs::path aside = make_temporary();
    fs::rename(this->object(object), aside / "object", error);
    remove_quietly(aside);
}

void remove_quietly(const fs::path& path)
{
    std::error_code error;
    fs::remove_all(path, error);
}

std::vector<fs::path> entries_of(const fs::path& folder)
{
    std::vector<fs::path> entries;
    std::error_code error;
    fs::directory_iterator entry(folder, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error))
        entries.push_back(entry->path());
    if (error && error != std::errc::no_such_file_or_directory)
        throw Error(folder.string() + ": cannot be listed: " + error.message());
    std::sort(entries.begin(), entries.end());
    return entries;
}

void rethrow_if_there(const fs::path& file)
{
    if (stamp_of(file))
        throw;
}

FileLock store_lock(const Store& store)
{
    return FileLock(store.lock_file("store"));
}

}  // namespace fresco::host

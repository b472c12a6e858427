#include "base/records.h"
#include "store/store.h"
#include <fresco/error.h>

#include <algorithm>
#include <functional>

// What keys led to.

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr std::size_t results_per_key = 8;

Value entry_of(const StoredResult& result)
{
    Value::List dependencies;
    for (const auto& dependency : result.dependencies)
        dependencies.push_back(to_value(dependency));
    Value value = Value::Map{{"object", result.object},
                             {"references", Value::List(result.references.begin(), result.references.end())},
                             {"dependencies", std::move(dependencies)}};
    if (!result.roots.is_null())
        value.set("roots", result.roots);
    return value;
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

Value roots_of_process()
{
    return input_roots().empty() ? Value() : to_value(input_roots());
}

void write_results(const Store& store, const std::string& key, const std::vector<StoredResult>& results)
{
    Value::List entries;
    for (const auto& result : results)
        entries.push_back(entry_of(result));
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

}  // namespace

Value to_value(const InputRoots& roots)
{
    Value::Map map;
    for (const auto& [name, folder] : roots)
        map.emplace_back(name, folder.string());
    return map;
}

InputRoots input_roots_from(const Value& value)
{
    InputRoots roots;
    for (const auto& [name, folder] : value.as_map())
        roots[name] = folder.as_string();
    return roots;
}

Value roots_for(const std::vector<Dependency>& dependencies)
{
    if (std::ranges::all_of(dependencies, [](const auto& dependency) { return is_input_name(dependency.stored_name()); }))
        return {};
    return roots_of_process();
}

StoredResult result_of(const std::string& object, const Value& value)
{
    StoredResult result{object, {}, {}};
    for (const auto& reference : value.at("references").as_list())
        result.references.push_back(reference.as_string());
    if (const Value* roots = value.find("roots"))
        result.roots = *roots;
    for (const auto& dependency : value.at("dependencies").as_list())
        result.dependencies.push_back(dependency_from(dependency));
    return result;
}

std::optional<StoredResult> Store::lookup(const std::string& key, std::string* why_not, const std::vector<fs::path>& files) const
{
    std::vector<StoredResult> results = results_of(*this, key);
    for (std::size_t i = 0; i < results.size(); ++i)
    {
        bool renewed = false;
        bool fits = results[i].dependencies.empty() || (contains_all(results[i].dependencies, files) &&
                                                        (results[i].roots.is_null() || results[i].roots == roots_of_process()));
        if (!fits && why_not != nullptr && why_not->empty())
            *why_not =
                (files.empty() ? "an input" : files.front().string()) + " has another path, and the stage reads more than it";
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
            for (const fs::path& path : entries_of(root_ / "objects"))
                objects_->insert(path.filename().string());
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
                results.push_back(result_of(*object, found));
        }
        catch (const Error&)
        {
            continue;  // Nothing was published there, or it is damaged.
        }
    }
    return !results.empty() && change_results(*this, key, [&] { return results; });
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
    std::vector<StoredResult> results = results_of(*this, key);
    std::erase_if(results, [&](const StoredResult& other) { return other.object == result.object; });
    results.insert(results.begin(), result);
    if (results.size() > results_per_key)
        results.resize(results_per_key);
    write_results(*this, key, results);
}

}  // namespace fresco::host

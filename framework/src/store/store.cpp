#include "store/store.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <mutex>
#include <sys/file.h>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr std::string_view store_format = "fresco store 1\n";
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

StoredResult result_from(const Value& value)
{
    StoredResult result;
    result.object = value.at("object").as_string();
    result.references = text_list(value.at("references"));
    for (const auto& dependency : value.at("dependencies").as_list())
        result.dependencies.push_back(dependency_from(dependency));
    return result;
}

/// An unreadable record counts as none: the stage runs again.
std::vector<StoredResult> read_results(const fs::path& file)
{
    std::vector<StoredResult> results;
    try
    {
        if (!fs::exists(file))
            return results;
        const Value entries = parse_json(read_text_file(file, std::size_t{1} << 30U), file.string());
        for (const auto& entry : entries.as_list())
            results.push_back(result_from(entry));
    }
    catch (const Error&)
    {
        results.clear();
    }
    return results;
}

void write_results(const fs::path& file, const std::vector<StoredResult>& results)
{
    Value::List entries;
    for (const auto& result : results)
        entries.push_back(to_value(result));
    write_file(file, to_json(Value(std::move(entries))));
}

/// Writes a result's new stamps. Where another process is at work on the same key, or the disk is full, the old ones stay: the
/// next look-up reads the files once more.
void renew(const Store& store, const std::string& key, const StoredResult& result)
{
    try
    {
        FileLock lock(store.lock_file(key));
        if (!lock.try_exclusive())
            return;
        std::vector<StoredResult> results = read_results(store.key_file(key));
        for (auto& other : results)
            if (other.object == result.object)
                other.dependencies = result.dependencies;
        write_results(store.key_file(key), results);
    }
    catch (const Error&)
    {
        return;
    }
}

}  // namespace

bool Store::is_at(const fs::path& folder)
{
    std::error_code error;
    return fs::exists(folder / "format", error);
}

Store::Store(fs::path root) : root_(std::move(root))
{
    std::error_code error;
    for (const char* folder : {"objects", "keys", "stages", "checkpoints", "logs", "locks", "tmp"})
    {
        fs::create_directories(root_ / folder, error);
        if (error)
            throw Error((root_ / folder).string() + ": cannot make the store's folder: " + error.message() +
                        "; choose another with --store");
    }
    const fs::path format = root_ / "format";
    if (!fs::exists(format))
        write_file(format, store_format);
    else if (const std::string found = read_text_file(format); found != store_format)
        throw Error(format.string() + ": the store is \"" + found.substr(0, found.find('\n')) + "\", this program needs \"" +
                    std::string(store_format.substr(0, store_format.size() - 1)) + "\"; choose another with --store");
}

fs::path Store::make_temporary(const std::string& prefix) const
{
    std::string pattern = (root_ / "tmp" / (prefix + ".XXXXXX")).string();
    if (mkdtemp(pattern.data()) == nullptr)
        throw Error((root_ / "tmp").string() + ": cannot make a folder: " + std::strerror(errno));
    return pattern;
}

void Store::remove_temporaries(const std::string& prefix) const
{
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(root_ / "tmp", error))
        if (entry.path().filename().string().starts_with(prefix))
            remove_quietly(entry.path());
}

std::optional<StoredResult> Store::lookup(const std::string& key, std::string* why_not) const
{
    std::vector<StoredResult> results = read_results(key_file(key));
    for (std::size_t i = 0; i < results.size(); ++i)
    {
        bool renewed = false;
        bool fits = true;
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
        if (renewed)
            renew(*this, key, results[i]);
        return results[i];
    }
    return std::nullopt;
}

void Store::remember(const std::string& key, const StoredResult& result) const
{
    std::vector<StoredResult> results = read_results(key_file(key));
    std::erase_if(results, [&](const StoredResult& other) { return other.object == result.object; });
    results.insert(results.begin(), result);
    if (results.size() > results_per_key)
        results.resize(results_per_key);
    write_results(key_file(key), results);
}

bool Store::present(std::string_view object) const
{
    return fs::exists(manifest_file(object));
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

std::string manifest_checksum(const Value& manifest)
{
    Value::Map entries = manifest.as_map();
    std::erase_if(entries, [](const Value::Entry& entry) { return entry.first == "checksum"; });
    return content_hash(to_json(Value(std::move(entries))));
}

Value Store::manifest(std::string_view object) const
{
    const fs::path file = manifest_file(object);
    Value manifest = parse_json(read_text_file(file, std::size_t{1} << 30U), file.string());
    if (manifest_checksum(manifest) != manifest.at("checksum").as_string())
        throw Error(file.string() + ": does not fit its own checksum");
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
    fs::remove(manifest_file(object), error);
    const fs::path aside = make_temporary();
    fs::rename(this->object(object), aside / "object", error);
    remove_quietly(aside);
}

void remove_quietly(const fs::path& path)
{
    std::error_code error;
    fs::remove_all(path, error);
}

FileLock::FileLock(const fs::path& file) : fd_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666))
{
    if (!fd_.valid())
        throw Error(file.string() + ": cannot be opened as a lock: " + std::strerror(errno));
}

bool FileLock::try_exclusive()
{
    return flock(fd_.get(), LOCK_EX | LOCK_NB) == 0;
}

bool FileLock::try_shared()
{
    return flock(fd_.get(), LOCK_SH | LOCK_NB) == 0;
}

void FileLock::wait_shared()
{
    while (flock(fd_.get(), LOCK_SH) != 0 && errno == EINTR)
        continue;
}

FileLock store_lock(const Store& store)
{
    return FileLock(store.lock_file("store"));
}

}  // namespace fresco::host

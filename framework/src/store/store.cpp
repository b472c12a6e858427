#include "store/store.h"
#include "base/process_identity.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>
#include <fresco/parallel.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <functional>
#include <random>
#include <sys/stat.h>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr const char* another_store = "choose another store with --store";
constexpr std::string_view store_format = "fresco store 2\n";
/// The first format's file had no checksum.
constexpr std::string_view first_format = "fresco store 1\n";

std::string gpu_text(const Value& gpus)
{
    std::vector<std::string> models;
    for (const auto& model : gpus.as_list())
        models.push_back(model.as_string());
    return models.empty() ? "none" : join(models);
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
    if (!path_status(file))
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
        if (!is_folder(root / "objects") || !is_folder(root / "keys"))
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
    return path_status(folder / "format").has_value();
}

Store::Store(fs::path root) : root_(std::move(root))
{
    try
    {
        make_folder(root_);
    }
    catch (const Error& error)
    {
        throw Error(std::string(error.what()) + "; " + another_store);
    }
    forbid_links_below(fs::absolute(root_), another_store);
    check_format(root_);
    for (const char* folder : {"objects", "keys", "stages", "checkpoints", "logs", "locks", "runs", "tmp"})
        make_folder(root_ / folder);
}

fs::path Store::make_temporary(std::string prefix) const
{
    if (prefix.empty())
        prefix = this_process().text();
    for (std::random_device random;;)
    {
        const fs::path folder = root_ / "tmp" / fmt::format("{}.{:08x}{:08x}", prefix, random(), random());
        const PathEntry entry(folder);
        // Nobody else's business before it is published: another user could swap a file for a link while a plugin writes it.
        if (entry.valid() && mkdirat(entry.folder(), entry.name(), 0700) == 0)
            return folder;
        if (!entry.valid() || errno != EEXIST)
            throw Error((root_ / "tmp").string() + ": cannot make a folder: " + std::strerror(errno));
    }
}

void Store::remove_temporaries(const std::string& prefix) const
{
    try
    {
        for (const fs::path& path : entries_of(root_ / "tmp"))
            if (path.filename().string().starts_with(prefix))
                remove_quietly(path);
    }
    catch (const Error&)
    {
        return;  // The next run removes them.
    }
}

bool Store::present(std::string_view object) const
{
    return is_file(manifest_file(object));
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
    try
    {
        // An estimate of no time at all would count as unknown.
        return std::clamp(std::strtod(read_text_file(checkpoint_file(key, ".share"), 100).c_str(), nullptr), 0.0, 0.99);
    }
    catch (const Error&)
    {
        return 0;
    }
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
        parts.push_back(dependency.stored_name() + '\0' + dependency.hash);
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
    const fs::path aside = make_temporary();
    rename_path(this->object(object), aside / "object");
    remove_quietly(aside);
}

void remove_quietly(const fs::path& path)
{
    try
    {
        remove_path(path);
    }
    catch (const Error&)
    {
        return;
    }
}

bool is_stored_name(std::string_view name)
{
    constexpr std::size_t digits = 32;
    return name.size() == digits && name.find_first_not_of("0123456789abcdef") == std::string_view::npos;
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

}  // namespace fresco::host

#include "store/store_copy.h"
#include "base/fault.h"
#include "store/publish.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <thread>
#include <vector>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

/// Throws Error where a file cannot be read or written.
void copy_files_of(const fs::path& from, const fs::path& to, const std::function<void()>& wait)
{
    constexpr std::size_t at_once = 8;  // A descriptor each.
    std::vector<FileCopy> copies;
    for (const auto& entry : fs::recursive_directory_iterator(from))
    {
        wait();
        const fs::path place = to / entry.path().lexically_relative(from);
        if (entry.is_directory())
            make_folder(place);
        else if (entry.path().parent_path() != from)
            copies.push_back({entry.path(), place});
        if (copies.size() == at_once)
        {
            copy_files(copies);
            copies.clear();
        }
    }
    copy_files(copies);
}

void take_lock(FileLock& lock, const fs::path& file, const std::function<void()>& wait)
{
    lock = FileLock(file);
    Backoff backoff;
    while (!lock.try_exclusive())
    {
        const auto end = std::chrono::steady_clock::now() + backoff.next();
        while (std::chrono::steady_clock::now() < end)
        {
            wait();
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
    }
    lock.sign();
}

/// The result as its manifest in `store` describes it; nothing without a whole manifest.
std::optional<Value> whole_manifest(const Store& store, const std::string& object)
{
    try
    {
        return store.manifest(object);
    }
    catch (const Error&)
    {
        return std::nullopt;
    }
}

}  // namespace

bool copy_result(const Store& from, const Store& to, const std::string& object, const std::function<void()>& wait,
                 CopiedResults& done)
{
    Value manifest;
    try
    {
        manifest = from.manifest(object);
    }
    catch (const Error& error)
    {
        done.damages.push_back({object, error.what()});
        return false;
    }
    for (const auto& reference : manifest.at("references").as_list())
    {
        const std::string& below = reference.as_string();
        if (to.present(below))
            continue;
        const std::optional<Value> its = whole_manifest(from, below);
        if (!its)
        {
            done.damages.push_back(
                {object, from.object(below).string() + ": is missing or damaged; " + object + " refers to it"});
            return false;
        }
        FileLock its_lock;
        take_lock(its_lock, to.lock_file(its->at("key").as_string()), wait);
        if (!copy_result(from, to, below, wait, done))
            return false;
    }
    to.look_again();
    const StoredResult result = result_of(object, manifest);
    if (whole_manifest(to, object))
    {
        to.remember(manifest.at("key").as_string(), result);
        ++done.there;
        return true;
    }
    const fs::path folder = to.make_temporary();
    try
    {
        copy_files_of(from.object(object), folder, wait);
        fault_point("copy.written");
        for (const auto& entry : manifest.at("files").as_list())
        {
            wait();
            if (auto damage = find_damage(folder, stored_file_from(entry)))
            {
                done.damages.push_back({object, from.object(object).string() + ": was not copied: " + *damage});
                remove_quietly(folder);
                return false;
            }
        }
        const double bytes = static_cast<double>(manifest.at("bytes").as_int());
        manifest.as_map().pop_back();  // Its checksum.
        put_in_place(to, folder, result, manifest);
        ++done.copied;
        done.copied_mb += bytes / (1024.0 * 1024.0);
        return true;
    }
    catch (...)
    {
        remove_quietly(folder);
        throw;
    }
}

CopiedResults copy_results(const Store& from, const Store& to, const std::vector<std::string>& objects,
                           const std::function<void()>& wait)
{
    std::vector<std::string> chosen = objects;
    for (const auto& object : chosen)
        if (!from.present(object))
            throw Error(from.object(object).string() + ": no such result; 'fresco store ls' lists them");
    if (chosen.empty())
        for (const auto& path : entries_of(from.root() / "objects"))
            if (const std::string id = path.filename().string(); from.present(id))
                chosen.push_back(id);
    CopiedResults done;
    for (const auto& object : chosen)
    {
        const std::optional<Value> manifest = whole_manifest(from, object);
        FileLock its_lock;
        if (manifest)
            take_lock(its_lock, to.lock_file(manifest->at("key").as_string()), wait);
        copy_result(from, to, object, wait, done);
    }
    return done;
}

}  // namespace fresco::host

#include "store/publish.h"
#include "base/common.h"
#include "base/fault.h"
#include "base/process.h"
#include "base/records.h"
#include "base/text.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace fresco::host
{

namespace
{

struct Tree
{
    std::vector<std::string> files;  ///< Sorted, relative.
    std::vector<fs::path> folders;
};

Tree list_tree(const fs::path& root, const std::vector<std::string>& outputs)
{
    Tree tree;
    for (const auto& output : outputs)
    {
        if (!is_folder(root / output))
            throw Error(output + ": the stage put something else in place of its output's folder");
        tree.folders.push_back(root / output);
        for (const auto& entry : fs::recursive_directory_iterator(root / output))
        {
            const std::string relative = entry.path().lexically_relative(root).generic_string();
            if (!is_utf8(relative))
                throw Error(relative + ": the name is not UTF-8 text; write the file under another name");
            if (entry.is_symlink() || !(entry.is_regular_file() || entry.is_directory()))
                throw Error(relative + ": not a regular file or folder; a result can hold nothing else");
            if (entry.is_directory())
                tree.folders.push_back(entry.path());
            else
                tree.files.push_back(relative);
        }
    }
    tree.folders.push_back(root);
    std::ranges::sort(tree.files);
    return tree;
}

void sync_tree(const fs::path& root, const Tree& tree)
{
    // One call for the whole file system is as safe as one per file, and much faster for thousands.
    constexpr std::size_t many = 64;
    if (tree.files.size() > many)
    {
        const FileDescriptor fd = open_file(root, O_RDONLY | O_DIRECTORY);
        if (!fd.valid() || uninterrupted([&] { return syncfs(fd.get()); }) != 0)
            throw Error(root.string() + ": cannot be written to the disk: " + std::strerror(errno));
        return;
    }
    for (const auto& file : tree.files)
        sync_file(root / file);
    for (const auto& folder : tree.folders)
        sync_folder(folder);
}

/// Gives a temporary folder the permissions that the process gives to new ones.
void open_to_others(const fs::path& folder)
{
    const FileDescriptor fd = open_file(folder, O_RDONLY | O_DIRECTORY);
    if (!fd.valid())
        throw Error(folder.string() + ": cannot be opened: " + std::strerror(errno));
    if (fchmod(fd.get(), 0777 & ~current_mask()) != 0)
        throw Error(folder.string() + ": its permissions cannot be set: " + std::strerror(errno) +
                    "; choose a store on another file system with --store");
}

/// With what those objects refer to themselves.
std::vector<std::string> closure(const Store& store, const std::set<std::string>& direct)
{
    std::set<std::string> all = direct;
    for (const auto& id : direct)
    {
        if (!store.present(id))
            continue;
        const Value manifest = store.manifest(id);
        for (const auto& further : manifest.at("references").as_list())
            all.insert(further.as_string());
    }
    return {all.begin(), all.end()};
}

void put_in_place(const Store& store, const fs::path& folder, const Tree& tree, const StoredResult& result, const Value& manifest)
{
    const std::string& key = manifest.at("key").as_string();
    sync_tree(folder, tree);
    fault_point("publish.synced");
    if (store.whole_manifest(result.object))
    {
        store.remember(key, result);
        remove_quietly(folder);
        return;
    }
    if (path_status(store.object(result.object)))
        store.discard(result.object);
    open_to_others(folder);
    if (!rename_path(folder, store.object(result.object)))
        throw Error(store.object(result.object).string() + ": cannot be put in place: " + std::strerror(errno));
    sync_folder(store.root() / "objects");
    fault_point("publish.renamed");
    // Before the manifest: a key that leads to nothing is harmless, a result that no key leads to would be made twice.
    store.remember(key, result);
    fault_point("publish.key");
    write_record(store.manifest_file(result.object), manifest);
    fault_point("publish.manifest");
}

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

/// copy_result of an object with this manifest, with the lock of its key.
bool copy_locked(const Store& from, const Store& to, const std::string& object, const Value& manifest,
                 const std::function<void()>& wait, CopiedResults& done)
{
    FileLock lock(to.lock_file(manifest.at("key").as_string()));
    for (Backoff backoff; !lock.try_exclusive();)
        backoff.wait(wait);
    lock.sign();
    return copy_result(from, to, object, wait, done);
}

}  // namespace

StoredResult publish(const Store& store, const fs::path& folder, const Publication& publication)
{
    const Tree tree = list_tree(folder, publication.outputs);
    const StoredResult result{object_id(publication.key, publication.dependencies), closure(store, publication.references),
                              publication.dependencies, roots_for(publication.dependencies)};
    Value manifest = publication.facts;
    Value::List files;
    std::uint64_t bytes = 0;
    for (const auto& file : tree.files)
    {
        const StoredFile hashed = hash_chunks(folder, file);
        bytes += hashed.size;
        files.push_back(to_value(hashed));
    }
    const auto without_stamp = [](Dependency dependency)
    {
        dependency.stamp.reset();
        return to_value(dependency);
    };
    manifest.set("key", publication.key);
    manifest.set("references", Value::List(result.references.begin(), result.references.end()));
    manifest.set("dependencies", each<Value>(publication.dependencies, without_stamp));
    if (!result.roots.is_null())
        manifest.set("roots", result.roots);
    manifest.set("bytes", bytes);
    manifest.set("files", std::move(files));

    fault_point("publish.written");
    put_in_place(store, folder, tree, result, manifest);
    return result;
}

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
        const std::optional<Value> its = from.whole_manifest(below);
        if (!its)
        {
            done.damages.push_back(
                {object, from.object(below).string() + ": is missing or damaged; " + object + " refers to it"});
            return false;
        }
        if (!copy_locked(from, to, below, *its, wait, done))
            return false;
    }
    to.look_again();
    const StoredResult result = result_of(object, manifest);
    if (to.whole_manifest(object))
    {
        to.remember(manifest.at("key").as_string(), result);
        ++done.there;
        return true;
    }
    const WorkFolder folder(to);
    copy_files_of(from.object(object), folder.path(), wait);
    fault_point("copy.written");
    for (const auto& entry : manifest.at("files").as_list())
    {
        wait();
        if (auto damage = find_damage(folder.path(), stored_file_from(entry)))
        {
            done.damages.push_back({object, from.object(object).string() + ": was not copied: " + *damage});
            return false;
        }
    }
    manifest.as_map().pop_back();  // Its checksum.
    const auto outputs = each(entries_of(folder.path()), [](const fs::path& output) { return output.filename().string(); });
    put_in_place(to, folder.path(), list_tree(folder.path(), outputs), result, manifest);
    ++done.copied;
    done.copied_mb += static_cast<double>(manifest.at("bytes").as_int()) / (1024.0 * 1024.0);
    return true;
}

CopiedResults copy_results(const Store& from, const Store& to, const std::vector<std::string>& objects,
                           const std::function<void()>& wait)
{
    std::vector<std::string> chosen = objects;
    for (const auto& object : chosen)
        if (!from.present(object))
            throw Error(from.object(object).string() + ": no such result; 'fresco store ls' lists them");
    if (chosen.empty())
        for (const auto& path : stored_objects(from))
            if (const std::string id = path.filename().string(); from.present(id))
                chosen.push_back(id);
    CopiedResults done;
    for (const auto& object : chosen)
    {
        if (const std::optional<Value> manifest = from.whole_manifest(object))
            copy_locked(from, to, object, *manifest, wait, done);
        else
            copy_result(from, to, object, wait, done);  // Says what is wrong with it.
    }
    return done;
}

}  // namespace fresco::host

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

}  // namespace

StoredResult publish(const Store& store, const fs::path& folder, const Publication& publication)
{
    const Tree tree = list_tree(folder, publication.outputs);
    const StoredResult result{object_id(publication.key, publication.dependencies), closure(store, publication.references),
                              publication.dependencies};
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
    manifest.set("bytes", bytes);
    manifest.set("files", std::move(files));

    fault_point("publish.written");
    put_in_place(store, folder, tree, result, manifest);
    return result;
}

}  // namespace fresco::host

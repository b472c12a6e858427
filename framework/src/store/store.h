#pragma once

#include "base/chunk_hash.h"
#include "base/file_lock.h"
#include "base/file_stamp.h"
#include <fresco/file_access.h>
#include <fresco/value.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file Results by key, on disk: looked up, verified, referred to. The layout of the folder is described here.

namespace fresco::host
{

/// A result as its key remembers it. The object may have been removed since.
struct StoredResult
{
    std::string object;
    std::vector<std::string> references;   ///< Other objects that its files refer to, theirs included.
    std::vector<Dependency> dependencies;  ///< Files it was made from that the key does not name.
};

/// By an entry of a key's record, or by the object's manifest.
StoredResult result_of(const std::string& object, const Value& value);

/// Raised where the files of a result are not those that were written.
struct Damage
{
    std::string object;
    std::string text;  ///< Names the file and what is wrong with it.
};

/// Default folder of the store.
inline constexpr const char* default_store = ".fresco";

/// The results of stages, in a folder:
///   objects/<id>/        one result: a folder per output, and manifest.json, written last; without it the folder is garbage
///   keys/<key>.json      what a key led to: up to 8 results, which differ in the outside files they were made from.
///   stages/<pipeline>/   the last result of each stage of a pipeline: what `gc` keeps and `plan` compares with
///   checkpoints/<key>/   of unfinished stages; beside it <key>.dependencies, <key>.curves and <key>.share
///   logs/<key>.log       what the stage printed when it last ran; beside the records, <stage>.log is a link to it
///   locks/, tmp/, files.jsonl (content hashes by stamp), stats.jsonl (measured costs): see Journal
/// No link below the folder is followed, and only names that a store makes are ever removed: see fresco/file_access.h.
/// Safe for several processes at once; objects never change once they have a manifest. All that is read back is checked against
/// checksums and against the name it is read by.
class Store
{
  public:
    /// Whether a store was made in this folder.
    static bool is_at(const std::filesystem::path& folder);
    /// Makes the folders. Throws Error if that fails, the store has another format, or the folder is neither empty nor a store.
    explicit Store(std::filesystem::path root);

    const std::filesystem::path& root() const { return root_; }
    std::filesystem::path object(std::string_view id) const { return root_ / "objects" / id; }
    std::filesystem::path manifest_file(std::string_view id) const { return object(id) / "manifest.json"; }
    std::filesystem::path key_file(std::string_view key) const { return root_ / "keys" / (std::string(key) + ".json"); }
    std::filesystem::path checkpoint(std::string_view key) const { return root_ / "checkpoints" / key; }
    /// A file beside the checkpoint: ".dependencies", ".curves", ".share".
    std::filesystem::path checkpoint_file(std::string_view key, std::string_view extension) const;
    /// Why a stage that computes at `place` (see computing_place) cannot go on with its checkpoint, which was made elsewhere:
    /// "its checkpoint was made on another type of processor (…)". Empty if it can, or if that is unknown. Throws Error if the
    /// record beside it is damaged.
    std::string checkpoint_refusal(std::string_view key, const Value& place) const;
    /// The share of the stage's work that its checkpoint holds, 0 to 0.99; 0 without one.
    double checkpoint_share(std::string_view key) const;
    /// The checkpoint and the files beside it, of a stage that is done; what cannot be removed stays.
    void remove_checkpoint(std::string_view key) const;
    /// Removes a checkpoint that must not be used: none of it comes back after a power cut. Throws Error if it stays.
    void drop_checkpoint(std::string_view key) const;
    std::filesystem::path log_file(std::string_view key) const { return root_ / "logs" / (std::string(key) + ".log"); }
    /// Index of FileHashes.
    std::filesystem::path file_index() const { return root_ / "files.jsonl"; }
    std::filesystem::path lock_file(std::string_view key) const { return root_ / "locks" / key; }
    /// A new empty folder below tmp/, only for this user, with a random name after `prefix` and a dot. See WorkFolder.
    std::filesystem::path make_temporary(const std::string& prefix = {}) const;
    /// Removes every temporary folder whose name begins with `prefix`, and what is in it.
    void remove_temporaries(const std::string& prefix) const;

    /// The result whose outside files are as they are now; renews stamps of files that were only touched. `why_not` is told
    /// which file changed, where that is the reason. `files`: the stage's input files, whose contents are in the key. What a
    /// stage read beside them is beside others where they have other paths.
    std::optional<StoredResult> lookup(const std::string& key, std::string* why_not = nullptr,
                                       const std::vector<std::filesystem::path>& files = {}) const;
    /// Call between taking a key's lock and looking it up: a network file system forgets which results were not there before.
    void look_again() const;
    /// Puts a result first among those of its key.
    void remember(const std::string& key, const StoredResult& result) const;
    /// Whether the object and all it refers to are there (not whether they are undamaged). Throws Error where that cannot be
    /// told.
    bool present(const StoredResult& result) const;
    bool present(std::string_view object) const;

    /// The manifest, checked against its own checksum and the object's name. Throws Error naming the file.
    Value manifest(std::string_view object) const;
    /// Manifest, or nothing if it is missing or damaged.
    std::optional<Value> whole_manifest(std::string_view object) const;
    /// Reads every file of an object (of output `below` alone, if given, which may have none) and compares. Uses up to `threads`
    /// threads.
    std::optional<Damage> verify(const std::string& object, int threads, const std::string& below = {}) const;
    /// Removes an object: its manifest first, so that nobody takes half of it for a result, not even after a power cut. Throws
    /// Error if the manifest cannot be removed.
    void discard(std::string_view object) const;

  private:
    std::filesystem::path root_;
};

/// A temporary folder that is removed with the object, unless it has another place by then.
class WorkFolder
{
  public:
    /// As Store::make_temporary.
    explicit WorkFolder(const Store& store, const std::string& prefix = {}) : path_(store.make_temporary(prefix)) {}
    ~WorkFolder();
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// The object's name: 16 digits of the key's hash, then 16 of the hash of the key and the contents of its dependencies.
std::string object_id(const std::string& key, const std::vector<Dependency>& dependencies);
/// How the names of all objects of this key begin.
std::string object_prefix(std::string_view key);

/// As make_folder; an error ends with what else to do: "choose another store with --store".
void make_folder_or(const std::filesystem::path& folder, const std::string& advice);
/// As remove_path; what cannot be removed stays.
void remove_quietly(const std::filesystem::path& path);
/// Whether a name can be a key or an object: 32 hexadecimal digits. Everything else in their folders is somebody else's, and
/// stays.
bool is_stored_name(std::string_view name);
/// Whether a name is that of a file on its way to another name, see temporary_file_prefix.
bool is_temporary_name(std::string_view name);
/// The folders of all objects, whole or not.
std::vector<std::filesystem::path> stored_objects(const Store& store);

/// In a handler: throws again what hinders from reading a file that is there. Neither is it damaged, nor may it count as gone.
void rethrow_if_there(const std::filesystem::path& file);

/// The lock that every run holds shared and that tidying up holds exclusively.
FileLock store_lock(const Store& store);
/// Takes that lock beside other runs; false while somebody tidies up. The only process in the store removes the leftovers of
/// killed ones first.
bool enter_store(const Store& store, FileLock& lock);
/// The folders that killed processes left in tmp/. Call it only while the store's lock keeps all others out.
std::vector<std::filesystem::path> abandoned_temporaries(const Store& store);

}  // namespace fresco::host

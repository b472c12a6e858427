#pragma once

#include "store/store.h"

#include <cstdint>
#include <string>
#include <vector>

/// \file Removes from a store what nothing uses: `fresco store gc`.

namespace fresco::host
{

struct StoredObject
{
    std::string id;
    std::string stage;
    std::string type;
    std::string key;
    std::int64_t time_s = 0;  ///< Unix time of publishing.
    double disk_mb = 0;       ///< Files that it shares with other results by hard links count in full.
    bool in_use = false;      ///< The last run of some pipeline uses it.
    bool whole = true;        ///< False: it has no readable manifest.
};

/// All objects, newest first.
std::vector<StoredObject> list_objects(const Store& store);

/// Re-reads every byte of every object.
std::vector<Damage> verify_store(const Store& store, int threads);

/// Removes an object that was found damaged, unless it was made anew since: takes the lock of its key and reads it again, on up
/// to `threads` threads. True if it is gone, false if it is whole. Throws Error if another run holds the key for 10 s.
bool discard_damaged(const Store& store, const std::string& object, int threads);

struct TidyResult
{
    std::vector<StoredObject> removed;
    double freed_mb = 0;
    int checkpoints = 0;
    int leftovers = 0;               ///< Temporary folders of killed runs.
    std::vector<std::string> stuck;  ///< Temporary folders that cannot be removed, each with the reason.
    double kept_mb = 0;              ///< Disk that `kept` use.
    int kept = 0;  ///< Old results, kept because a pipeline whose file cannot be seen used them within `keep_days`.
};

/// Removes results that no pipeline's last run used and that are older than `keep_days`, half-written ones, checkpoints of
/// finished stages and those older than that, the logs of both, and what killed runs left. A pipeline whose file cannot be seen
/// counts until its last run is that old. Works where the disk has no room for another file. Throws Error if a run is using the
/// store.
TidyResult tidy_store(const Store& store, double keep_days, bool dry_run);

}  // namespace fresco::host

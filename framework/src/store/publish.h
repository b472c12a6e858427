#pragma once

#include "store/store.h"

#include <functional>
#include <set>
#include <string>
#include <vector>

/// \file How results come into a store: whole, verified, and on the disk before their name. A worker publishes; `store copy`
/// and --upstream copy.

namespace fresco::host
{

/// A finished stage on its way into the store.
struct Publication
{
    std::string key;
    std::vector<std::string> outputs;  ///< Names; a folder of each lies in the temporary folder.
    std::vector<Dependency> dependencies;
    /// Entries of the manifest that the store does not make itself: stage, type, key_document, report, messages, seconds, …
    Value facts;
    std::set<std::string> references{};  ///< Other objects that the outputs refer to.
};

/// Makes `folder` (from Store::make_temporary) an object: hashes, fsyncs, renames, remembers it under its key, writes the
/// manifest last. If the object is there already, whole, that one stays and `folder` is removed. The caller holds the key's lock.
/// Throws Error if a file cannot be written or is of a kind that cannot be stored; nothing is published then.
StoredResult publish(const Store& store, const std::filesystem::path& folder, const Publication& publication);

struct CopiedResults
{
    std::size_t copied = 0;
    std::size_t there = 0;  ///< Were there before.
    double copied_mb = 0;
    /// Of results that were not copied, as they, or those that they refer to, are damaged in `from`.
    std::vector<Damage> damages;
};

/// Copies a result, and before it those that it refers to, from one store to another: its files first, verified against its
/// manifest, then what leads to it, its manifest last. The caller holds the lock of the result's key in `to`. Those of other keys
/// are taken, and waited for. `wait` is asked several times a second meanwhile, and may throw. Adds to `done`; true if the result
/// is whole in `to` now. Throws Error if a file of `to` cannot be written.
bool copy_result(const Store& from, const Store& to, const std::string& object, const std::function<void()>& wait,
                 CopiedResults& done);

/// The same of several, with their keys' locks. Empty: all. Throws Error if `from` has no such result.
CopiedResults copy_results(const Store& from, const Store& to, const std::vector<std::string>& objects,
                           const std::function<void()>& wait);

}  // namespace fresco::host

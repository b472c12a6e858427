#pragma once

#include "store/store.h"

#include <set>
#include <string>
#include <vector>

/// \file How results come into a store: whole, and on the disk before their name. A worker publishes its stage's result.

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

}  // namespace fresco::host

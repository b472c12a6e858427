#pragma once

#include "store/store.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace fresco::host
{

struct CopiedResults
{
    std::size_t copied = 0;
    std::size_t there = 0;  ///< Were there before.
    double copied_mb = 0;
    std::vector<Damage>
        damages;  ///< Of results that were not copied, as they, or those that they refer to, are damaged in `from`.
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

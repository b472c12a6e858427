#pragma once

#include "store/presence.h"

#include <string>

namespace fresco::host
{

/// A process at work in a store beside others, while nobody tidies up.
class StoreUse
{
  public:
    /// `lender`: another store that this one gets results from; null: none. Nobody tidies up there meanwhile, unless its files
    /// may not be written, or somebody has begun. Throws Error as Presence does.
    explicit StoreUse(const Store& store, const Store* lender = nullptr);

    /// False while somebody tidies up. Who finds nobody else in the store removes what killed processes left.
    bool try_enter();
    /// Who tidies up: "process 4711 on kitchen, since …"; empty: unknown.
    std::string tidier() const;
    /// See Presence.
    void beat() { presence_.beat(); }

  private:
    const Store& store_;
    Presence presence_;
    FileLock lock_;
    FileLock lender_lock_;
};

}  // namespace fresco::host

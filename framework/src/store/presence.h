#pragma once

#include "base/file_lock.h"
#include "store/store.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

/// \file Tells clean-ups which runs use a store, on this machine and on others, so that nothing is removed under them.

namespace fresco::host
{

/// A process at work in a store, as others see it, also those of other machines: runs/<ProcessIdentity>, locked as long as the
/// process lives, signed, and touched every second.
class Presence
{
  public:
    /// Throws Error within five seconds where locks do not keep processes apart: on this machine (broken_lock), or between
    /// machines, where this one can lock the file of a process elsewhere that goes on touching it. Removes the files of processes
    /// that have ended. The process must be single-threaded.
    explicit Presence(const Store& store);
    ~Presence();
    Presence(const Presence&) = delete;
    Presence& operator=(const Presence&) = delete;

    /// Call several times a second: touches the file once a second.
    void beat();

  private:
    std::filesystem::path file_;
    FileLock lock_;
    std::chrono::steady_clock::time_point next_beat_;
};

/// Who is at work in the store: "process 4711 on kitchen, since 2026-11-23 13:05:10", one after the other; empty: nobody that has
/// said so.
std::string present_processes(const Store& store);

/// What killed processes left in tmp/. Not that of processes of this machine that run, nor of other machines' as long as they
/// have a file in runs/: their numbers mean nothing here.
std::vector<std::filesystem::path> abandoned_temporaries(const Store& store);

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

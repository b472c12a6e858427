#pragma once

#include "base/file_lock.h"
#include "store/store.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

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

}  // namespace fresco::host

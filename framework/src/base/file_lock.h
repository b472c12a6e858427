#pragma once

#include "base/process.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <sys/file.h>
#include <utility>

/// \file Locks between processes and machines that share a store: one makes a result, others wait and read who it is. Held by
/// the worker, by runs, and by clean-ups.

namespace fresco::host
{

/// A kernel lock on a file: ends with the process at the latest. All throw Error where the file system has no locks.
class FileLock
{
  public:
    FileLock() = default;
    /// Opens (makes) the file. Throws Error if that fails.
    explicit FileLock(std::filesystem::path file);
    /// Tries without waiting. What somebody removed meanwhile is made again.
    bool try_exclusive() { return try_lock(LOCK_EX); }
    bool try_shared() { return try_lock(LOCK_SH); }
    /// Tries as long as that, once a second at least.
    bool try_exclusive_for(std::chrono::milliseconds patience);
    /// Waits.
    void wait_shared();
    /// For a program that is to hold the lock too.
    int descriptor() const { return fd_.get(); }

    /// Writes this process into the locked file, for people who wait. What cannot be written is left out.
    void sign() const;
    /// Last signature in the file: "process 4711 on kitchen, since 2026-11-23 13:05:10"; empty: none.
    static std::string holder_of(const std::filesystem::path& file);

  private:
    void open();
    bool try_lock(int kind);
    [[noreturn]] void fail() const;

    std::filesystem::path file_;
    FileDescriptor fd_;
};

/// How long to wait before trying a lock again: 50 ms at first, two seconds at last.
class Backoff
{
  public:
    std::chrono::milliseconds next() { return std::exchange(time_, std::min(2 * time_, std::chrono::milliseconds(2000))); }
    /// Waits that long, and calls `meanwhile` every 50 ms, which may throw.
    void wait(const std::function<void()>& meanwhile);

  private:
    std::chrono::milliseconds time_{50};
};

}  // namespace fresco::host

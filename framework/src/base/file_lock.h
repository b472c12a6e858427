#pragma once

#include "base/process.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <sys/file.h>

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

}  // namespace fresco::host

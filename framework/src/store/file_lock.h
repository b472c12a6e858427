#pragma once

#include "base/process.h"

#include <filesystem>
#include <sys/file.h>

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
    /// Waits.
    void wait_shared();
    /// For a program that is to hold the lock too.
    int descriptor() const { return fd_.get(); }

  private:
    void open();
    bool try_lock(int kind);
    [[noreturn]] void fail() const;

    std::filesystem::path file_;
    FileDescriptor fd_;
};

}  // namespace fresco::host

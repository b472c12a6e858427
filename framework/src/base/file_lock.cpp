#include "base/file_lock.h"
#include "base/common.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <fmt/chrono.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace fresco::host
{
namespace
{

constexpr std::string_view holder_begin = "process ";

/// Ends errors about locks that do not work.
constexpr const char* lock_advice = ": a store needs a file system with locks; choose another with --store";

/// Says by errno why a file cannot be opened as a lock, which is not the fault of the file system's locks.
std::string lack_text()
{
    const int error = errno;
    const bool full = error == ENOSPC || error == EDQUOT;
    const char* advice = full              ? ": free some space (df) or files (df -i), or choose another store with --store"
                         : error == EMFILE ? ": raise the limit (ulimit -n)"
                                           : "";
    return std::strerror(error) + std::string(advice);
}

}  // namespace

FileLock::FileLock(std::filesystem::path file) : file_(std::move(file))
{
    open();
}

void FileLock::open()
{
    fd_ = open_file(file_, O_RDWR | O_CREAT);
    if (!fd_.valid())
        throw Error(file_.string() + ": cannot be opened as a lock: " + lack_text());
}

void FileLock::fail() const
{
    throw Error(file_.string() + ": cannot be locked: " + std::strerror(errno) + lock_advice);
}

bool FileLock::try_lock(int kind)
{
    for (;;)
    {
        if (uninterrupted([&] { return flock(fd_.get(), kind | LOCK_NB); }) != 0)
        {
            if (errno == EWOULDBLOCK)
                return false;
            fail();
        }
        struct stat locked = {};
        const auto named = path_status(file_);
        if (fstat(fd_.get(), &locked) == 0 && named && locked.st_ino == named->st_ino && locked.st_dev == named->st_dev)
            return true;
        open();
    }
}

bool FileLock::try_exclusive_for(std::chrono::milliseconds patience)
{
    const auto end = std::chrono::steady_clock::now() + patience;
    while (!try_exclusive())
    {
        if (std::chrono::steady_clock::now() >= end)
            return false;
        std::this_thread::sleep_for(
            std::clamp<std::chrono::milliseconds>(patience / 100, std::chrono::milliseconds(20), std::chrono::seconds(1)));
    }
    return true;
}

void FileLock::sign() const
{
    // Opened for this and closed at once: others then see it on a network file system.
    const FileDescriptor fd = open_file(file_, O_WRONLY | O_TRUNC);
    char host[256] = {};
    gethostname(host, sizeof host - 1);
    const std::string line =
        fmt::format("process {} on {}, since {:%Y-%m-%d %H:%M:%S}\n", getpid(), host, fmt::localtime(std::time(nullptr)));
    if (fd.valid())
        (void)!uninterrupted([&] { return write(fd.get(), line.data(), line.size()); });
}

std::string FileLock::holder_of(const std::filesystem::path& file)
{
    constexpr std::size_t longest = 400;
    const std::string text = attempt([&] { return read_text_file(file, longest); }).value_or("");
    const std::string line = text.substr(0, text.find('\n'));
    const bool fits = line.size() < text.size() && line.starts_with(holder_begin) &&
                      std::ranges::all_of(line, [](char c) { return c >= ' ' && c <= '~'; });
    return fits ? line : "";
}

}  // namespace fresco::host

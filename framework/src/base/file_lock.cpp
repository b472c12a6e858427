#include "base/file_lock.h"
#include "base/common.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <new>
#include <poll.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace fresco::host
{
namespace
{

constexpr std::string_view holder_begin = "process ";

/// Ends errors about locks that do not work.
constexpr const char* lock_advice = ": a store needs a file system with locks; choose another with --store";

/// Says by errno why a file cannot be opened as a lock, or no process can be started to try it. Neither is the fault of the file
/// system's locks.
std::string lack_text()
{
    const std::string reason = std::strerror(errno);
    if (errno == ENOSPC || errno == EDQUOT)
        return reason + ": free some space (df) or files (df -i), or choose another store with --store";
    if (errno == EMFILE)
        return reason + ": raise the limit (ulimit -n)";
    return with_process_limit(reason);
}

/// What is wrong with the locks of this file; empty: nothing.
std::string lock_problem(const std::filesystem::path& file)
{
    FileDescriptor descriptors[2];
    for (FileDescriptor& fd : descriptors)
    {
        fd = open_file(file, O_RDWR | O_CREAT);
        if (!fd.valid())
            return "cannot be opened as a lock: " + lack_text();
    }
    const auto gets = [&](int which, int operation)
    { return uninterrupted([&] { return flock(descriptors[which].get(), operation | LOCK_NB); }) == 0; };
    if (!gets(0, LOCK_EX))
        return std::string("cannot be locked: ") + std::strerror(errno) + lock_advice;
    for (const int operation : {LOCK_EX, LOCK_SH})
        if (gets(1, operation))
            return std::string("was locked twice at once") + lock_advice;
    if (errno != EWOULDBLOCK)
        return std::string("cannot be locked: ") + std::strerror(errno) + lock_advice;
    if (!gets(0, LOCK_UN) || !gets(1, LOCK_EX))
        return std::string("stays locked after it was unlocked") + lock_advice;
    return "";
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

void Backoff::wait(const std::function<void()>& meanwhile)
{
    for (const auto end = std::chrono::steady_clock::now() + next(); std::chrono::steady_clock::now() < end;)
    {
        meanwhile();
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
}

void FileLock::wait_shared()
{
    if (uninterrupted([&] { return flock(fd_.get(), LOCK_SH); }) != 0)
        fail();
}

void FileLock::sign() const
{
    // Opened for this and closed at once: others then see it on a network file system.
    const FileDescriptor fd = open_file(file_, O_WRONLY | O_TRUNC);
    const std::string line = holder_text() + '\n';
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

std::string broken_lock(const std::filesystem::path& file)
{
    constexpr int patience_ms = 3000;
    constexpr char no_memory = '\0';
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return "cannot be tried as a lock: " + lack_text();
    const FileDescriptor said(ends[0]);
    FileDescriptor says(ends[1]);
    const pid_t child = fork();
    if (child < 0)
        return "cannot be tried as a lock: " + lack_text();
    if (child == 0)
    {
        try
        {
            const std::string problem = lock_problem(file) + '\n';
            _exit(write(says.get(), problem.data(), problem.size()) < 0 ? 1 : 0);
        }
        catch (const std::bad_alloc&)
        {
            _exit(write(says.get(), &no_memory, 1) < 0 ? 1 : 0);
        }
        catch (...)
        {
            _exit(1);
        }
    }
    says = FileDescriptor();
    pollfd entry{said.get(), POLLIN, 0};
    const bool answered = uninterrupted([&] { return poll(&entry, 1, patience_ms); }) > 0;
    // It may be where no signal reaches it; then it is left to its end.
    kill(child, SIGKILL);
    for (int tries = 0; tries < 100 && waitpid(child, nullptr, WNOHANG) == 0; ++tries)
        poll(nullptr, 0, 1);
    if (!answered)
        return "cannot be locked: flock did not return within " + std::to_string(patience_ms / 1000) + " seconds" + lock_advice;
    char text[512];
    const ssize_t count = uninterrupted([&] { return read(said.get(), text, sizeof text); });
    if (count <= 0)
        return "cannot be tried as a lock: the process that tried it ended";
    if (text[0] == no_memory)
        throw std::bad_alloc();
    return {text, static_cast<std::size_t>(count - 1)};
}

}  // namespace fresco::host

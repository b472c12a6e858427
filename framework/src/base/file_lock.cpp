#include "base/file_lock.h"
#include "base/process_identity.h"
#include <fresco/error.h>
#include <fresco/retry.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <poll.h>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

constexpr std::string_view holder_begin = "process ";

/// What is wrong with the locks of this file; empty: nothing.
std::string lock_problem(const std::filesystem::path& file)
{
    FileDescriptor descriptors[2];
    for (FileDescriptor& fd : descriptors)
    {
        fd = FileDescriptor(uninterrupted([&] { return ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666); }));
        if (!fd.valid())
            return std::string("cannot be opened as a lock: ") + std::strerror(errno);
    }
    const auto gets = [&](int which, int operation)
    { return uninterrupted([&] { return flock(descriptors[which].get(), operation | LOCK_NB); }) == 0; };
    if (!gets(0, LOCK_EX))
        return std::string("cannot be locked: ") + std::strerror(errno);
    for (const int operation : {LOCK_EX, LOCK_SH})
        if (gets(1, operation))
            return "was locked twice at once";
    if (errno != EWOULDBLOCK)
        return std::string("cannot be locked: ") + std::strerror(errno);
    if (!gets(0, LOCK_UN) || !gets(1, LOCK_EX))
        return "stays locked after it was unlocked";
    return "";
}

}  // namespace

FileLock::FileLock(std::filesystem::path file) : file_(std::move(file))
{
    open();
}

void FileLock::open()
{
    fd_ = FileDescriptor(uninterrupted([&] { return ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666); }));
    if (!fd_.valid())
        throw Error(file_.string() + ": cannot be opened as a lock: " + std::strerror(errno));
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
        struct stat named = {};
        if (fstat(fd_.get(), &locked) == 0 && stat(file_.c_str(), &named) == 0 && locked.st_ino == named.st_ino &&
            locked.st_dev == named.st_dev)
            return true;
        open();
    }
}

void FileLock::wait_shared()
{
    if (uninterrupted([&] { return flock(fd_.get(), LOCK_SH); }) != 0)
        fail();
}

void FileLock::sign() const
{
    // Closed at once: what lies in a network file system is then seen by others.
    std::ofstream(file_) << holder_text() << '\n';
}

std::string FileLock::holder_of(const std::filesystem::path& file)
{
    std::string line;
    std::ifstream stream(file);
    std::getline(stream, line);
    constexpr std::size_t longest = 400;
    const bool fits = line.starts_with(holder_begin) && line.size() < longest &&
                      std::ranges::all_of(line, [](char c) { return c >= ' ' && c <= '~'; });
    return fits ? line : "";
}

std::string broken_lock(const std::filesystem::path& file)
{
    constexpr int patience_ms = 3000;
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return std::string("cannot be tried as a lock: ") + std::strerror(errno);
    const FileDescriptor said(ends[0]);
    FileDescriptor says(ends[1]);
    const pid_t child = fork();
    if (child < 0)
        return std::string("cannot be tried as a lock: ") + std::strerror(errno);
    if (child == 0)
    {
        try
        {
            const std::string problem = lock_problem(file) + '\n';
            _exit(write(says.get(), problem.data(), problem.size()) < 0 ? 1 : 0);
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
        return "cannot be locked: flock did not return within " + std::to_string(patience_ms / 1000) + " seconds";
    char text[512];
    const ssize_t count = uninterrupted([&] { return read(said.get(), text, sizeof text); });
    if (count <= 0)
        return "cannot be tried as a lock: the process that tried it ended";
    return {text, static_cast<std::size_t>(count - 1)};
}

}  // namespace fresco::host

#include "store/file_lock.h"
#include <fresco/error.h>
#include <fresco/retry.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <sys/stat.h>

namespace fresco::host
{

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
    throw Error(file_.string() + ": cannot be locked: " + std::strerror(errno) +
                ": a store needs a file system with locks; choose another with --store");
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

}  // namespace fresco::host

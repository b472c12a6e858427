/* Loaded before the C library (LD_PRELOAD), in place of a file system that lacks something. LACKING_FLOCK: there
 * are no locks. LACKING_TMPFILE: there are no files without names.
 * LACKING_NAMES: as in a network file system, a process sees the records of keys that it has listed. LACKING_INODES: there is no
 * room for another file. LACKING_CHARACTERS: names have no ':'. LACKING_PERMISSIONS: a mount with permissions of its own.
 * LACKING_SPEED: a file gets its name in two milliseconds. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static int fails(int reason)
{
    errno = reason;
    return -1;
}

int flock(int fd, int operation)
{
    return getenv("LACKING_FLOCK") != NULL ? fails(ENOSYS) : (int)syscall(SYS_flock, fd, operation);
}

int mkdirat(int folder, const char* path, mode_t mode)
{
    if (getenv("LACKING_INODES") != NULL && faccessat(folder, path, F_OK, 0) != 0)
        return fails(ENOSPC);
    return (int)syscall(SYS_mkdirat, folder, path, mode);
}

int renameat(int folder, const char* path, int new_folder, const char* new_path)
{
    if (getenv("LACKING_CHARACTERS") != NULL && strchr(new_path, ':') != NULL)
        return fails(EINVAL);
    if (getenv("LACKING_SPEED") != NULL)
        usleep(2000);
    return (int)syscall(SYS_renameat2, folder, path, new_folder, new_path, 0);
}

int fchmod(int fd, mode_t mode)
{
    return getenv("LACKING_PERMISSIONS") != NULL ? fails(EPERM) : (int)syscall(SYS_fchmod, fd, mode);
}

int openat(int folder, const char* path, int flags, ...)
{
    static int listed = 0;
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if ((flags & O_TMPFILE) == O_TMPFILE && getenv("LACKING_TMPFILE") != NULL)
        return fails(EOPNOTSUPP);
    const int makes = (flags & O_TMPFILE) == O_TMPFILE || ((flags & O_CREAT) != 0 && faccessat(folder, path, F_OK, 0) != 0);
    if (makes && getenv("LACKING_INODES") != NULL)
        return fails(ENOSPC);
    if (getenv("LACKING_NAMES") != NULL)
    {
        const char* end = strstr(path, "/keys");
        if (end != NULL && strcmp(end, "/keys") == 0)
            listed = 1;
        else if (end != NULL && strncmp(end, "/keys/", 6) == 0 && (flags & O_ACCMODE) == O_RDONLY && !listed)
            return fails(ENOENT);
    }
    return (int)syscall(SYS_openat, folder, path, flags, mode);
}

int open(const char* path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return openat(AT_FDCWD, path, flags, mode);
}

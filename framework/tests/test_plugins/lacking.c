/* Loaded before the C library (LD_PRELOAD), in place of a file system that lacks something. LACKING_FLOCK: flock fails with the error
 * of this number, "blocks" for ever, or is "granted" to everybody. LACKING_TMPFILE: there are no files without names. LACKING_NAMES: as
 * in a network file system, a process sees the records of keys that it has listed. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

int flock(int fd, int operation)
{
    const char* how = getenv("LACKING_FLOCK");
    if (how == NULL)
        return (int)syscall(SYS_flock, fd, operation);
    if (strcmp(how, "granted") == 0)
        return 0;
    while (strcmp(how, "blocks") == 0)
        pause();
    errno = atoi(how);
    return -1;
}

int openat(int folder, const char* path, int flags, ...)
{
    static int listed = 0;
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if ((flags & O_TMPFILE) == O_TMPFILE && getenv("LACKING_TMPFILE") != NULL)
    {
        errno = EOPNOTSUPP;
        return -1;
    }
    if (getenv("LACKING_NAMES") != NULL)
    {
        const char* end = strstr(path, "/keys");
        if (end != NULL && strcmp(end, "/keys") == 0)
            listed = 1;
        else if (end != NULL && strncmp(end, "/keys/", 6) == 0 && (flags & O_ACCMODE) == O_RDONLY && !listed)
        {
            errno = ENOENT;
            return -1;
        }
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

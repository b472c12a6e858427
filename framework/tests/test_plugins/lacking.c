/* Loaded before the C library (LD_PRELOAD): flock fails with the error that LACKING_FLOCK names, and where LACKING_TMPFILE is set
 * the file system has no files without names. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

int flock(int fd, int operation)
{
    const char* number = getenv("LACKING_FLOCK");
    if (number == NULL)
        return (int)syscall(SYS_flock, fd, operation);
    errno = atoi(number);
    return -1;
}

int open(const char* path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if ((flags & O_TMPFILE) == O_TMPFILE && getenv("LACKING_TMPFILE") != NULL)
    {
        errno = EOPNOTSUPP;
        return -1;
    }
    return openat(AT_FDCWD, path, flags, mode);
}
